"""Recordings: looking into what was recorded, and measuring it again."""

from station.page.recordings.routes import router

__all__ = ["router"]
