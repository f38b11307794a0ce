"""Calibration: sessions, reports, what is in force and how it drifts."""

from fastapi import APIRouter

from station.page.calibration import (
    deciding_routes,
    history_routes,
    report_routes,
    rig_routes,
    routes,
    session_routes,
)

router = APIRouter()
for part in (
    routes,
    session_routes,
    report_routes,
    rig_routes,
    deciding_routes,
    history_routes,
):
    router.include_router(part.router)

__all__ = ["router"]
