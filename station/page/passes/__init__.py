"""Passes: trains, their wheels, and each wheel over time."""

from station.page.passes.routes import router
from station.page.passes.wheel_routes import router as wheel_router

router.include_router(wheel_router)

__all__ = ["router"]
