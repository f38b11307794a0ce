"""Passes: trains, their wheels, and each wheel over time."""

from station.page.passes.routes import router

__all__ = ["router"]
