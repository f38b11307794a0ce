"""Who waits for a picture: one is made at a time, and few wait, for a train may pass meanwhile."""

from collections import defaultdict
from collections.abc import Callable
from typing import TypeVar

from anyio import CapacityLimiter, to_thread

from station.api.refusals import PicturesBusy

_MOST_WAITING = 24
"""Browsers ask for six pictures of a film strip at a time."""
_Made = TypeVar("_Made")


def _one_at_a_time() -> CapacityLimiter:
    return CapacityLimiter(1)


class Turns:
    """Turns at the viewing process, and at each camera that is looked through."""

    def __init__(self) -> None:
        self._of: defaultdict[str | None, CapacityLimiter] = defaultdict(_one_at_a_time)

    async def take(self, sensor: str | None, make: Callable[[], _Made]) -> _Made:
        """Return what `make` makes once those before have theirs; who waits holds no thread.

        Parameters
        ----------
        sensor
            Whose camera is needed; None where none is.  A camera that does not answer keeps
            nobody from what others saw.

        Raises
        ------
        PicturesBusy
            If too many wait already.
        """
        limiter = self._of[sensor]
        if limiter.statistics().tasks_waiting >= _MOST_WAITING:
            raise PicturesBusy(f"{_MOST_WAITING} calls wait for pictures already; ask again later")
        return await to_thread.run_sync(make, limiter=limiter)
