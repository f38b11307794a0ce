"""Calibration: sessions, reports, what is in force and how it drifts."""

from station.page.calibration.routes import router

__all__ = ["router"]
