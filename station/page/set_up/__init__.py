"""Set-up: keys, sensors, limits, the nightly job, and what the host lacks."""

from station.page.set_up.routes import router

__all__ = ["router"]
