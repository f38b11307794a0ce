"""An API process that dies at a moment a test chooses, as by kill -9, without a process.

All that lasts outside the process are its changes of the store and its orders to capture and
worker.  From the moment of its death on none of these has any effect: whatever its code still
does, in `finally` or in another thread, stays within it.
"""

from contextlib import contextmanager
from dataclasses import replace
from threading import RLock

from station.operations import Station


class Died(BaseException):
    """The process is dead; no `except Exception` of its code may hold that up."""


class Life:
    """Of one API process: without end, or until it has done so many deeds that last."""

    def __init__(self) -> None:
        self._lock = RLock()
        self._left: int | None = None
        self.dead = False

    def end_after(self, deeds: int) -> None:
        """Let it do so many more deeds; with none it is dead at once."""
        self._left = deeds
        self.dead = deeds == 0

    def ensure(self) -> None:
        if self.dead:
            raise Died

    @contextmanager
    def deed(self):
        """Do something that lasts, one after the other, and perhaps die of it."""
        with self._lock:
            self.ensure()
            yield
            if self._left is not None:
                self._left -= 1
                self.dead = self._left == 0
            self.ensure()


class _MortalStore:
    def __init__(self, store, life):
        self._store, self._life = store, life
        self.look, self.ensure_answers = store.look, store.ensure_answers
        self.revisions = store.revisions

    @contextmanager
    def change(self):
        with self._life.deed(), self._store.change() as session:
            yield session


class _MortalOrders:
    """A double of capture or worker as the process sees it."""

    def __init__(self, double, life):
        self._double, self._life = double, life

    def __getattr__(self, name):
        order = getattr(self._double, name)

        def give(*args, **kwargs):
            if name == "status":
                self._life.ensure()
                return order(*args, **kwargs)
            with self._life.deed():
                return order(*args, **kwargs)

        return give


def mortal(station: Station, life: Life) -> Station:
    """Return the station as an API process of that life has it."""
    return replace(
        station,
        store=_MortalStore(station.store, life),
        captures={name: _MortalOrders(each, life) for name, each in station.captures.items()},
        jobs=_MortalOrders(station.jobs, life),
    )
