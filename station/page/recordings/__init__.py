"""Recordings: looking into what was recorded, and measuring it again."""

from fastapi import APIRouter

from station.page.recordings import replay_routes, routes

router = APIRouter()
# First: its addresses are longer than those that a recording's name ends.
router.include_router(replay_routes.router)
router.include_router(routes.router)

__all__ = ["router"]
