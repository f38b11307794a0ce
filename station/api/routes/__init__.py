"""The routes, a file for each thing they are about."""

from fastapi import APIRouter

from station.api.routes import (
    audit,
    calibrations,
    health,
    jobs,
    passes,
    recalibrations,
    recordings,
    results,
    rigs,
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
    recalibrations.router,
    rigs.router,
    jobs.router,
    recordings.router,
    results.router,
    wheelsets.router,
    audit.router,
)

__all__ = ["ROUTERS"]
