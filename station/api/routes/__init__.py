"""The routes, a file for each thing they are about."""

from fastapi import APIRouter

from station.api.routes import (
    audit,
    calibrations,
    frames,
    health,
    jobs,
    passes,
    recalibrations,
    recorded_events,
    recordings,
    replays,
    results,
    rigs,
    sensor_pictures,
    sessions,
    station,
    wheelsets,
)

ROUTERS: tuple[APIRouter, ...] = (
    health.router,
    station.router,
    sensor_pictures.router,
    passes.router,
    sessions.router,
    calibrations.router,
    recalibrations.router,
    rigs.router,
    jobs.router,
    recordings.router,
    frames.router,
    recorded_events.router,
    results.router,
    replays.router,
    wheelsets.router,
    audit.router,
)

__all__ = ["ROUTERS"]
