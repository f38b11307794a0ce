"""Now: what each sensor sees and does."""

from station.page.now.routes import router

__all__ = ["router"]
