"""The routes, a file for each thing they are about."""

from fastapi import APIRouter

from station.api.routes import (
    calibrations,
    health,
    jobs,
    passes,
    recordings,
    results,
    sessions,
    station,
    wheelsets,
)

ROUTERS: tuple[APIRouter, ...] = (
    health.router,
    station.router,
    passes.router,
    sessions.router,
    calibrations.router,
    jobs.router,
    recordings.router,
    results.router,
    wheelsets.router,
)

__all__ = ["ROUTERS"]
