"""Sending round by round; where the fleet is away, seldomer and seldomer, for as long as it is."""

from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Protocol

import structlog

from station.errors import StationError
from station.fleet.note import FleetNote, read_note, write_note
from station.fleet.pushing import Pushed

_FIRST_PAUSE_S = 1.0
_log = structlog.get_logger()


class Stop(Protocol):
    """Says when to stop."""

    def is_set(self) -> bool: ...

    def wait(self, timeout: float) -> bool: ...


class Follower:
    """Has a round made every so often, and notes how it went.

    Parameters
    ----------
    push
        Makes a round.
    folder
        Where the note goes.
    every_s, longest_pause_s
        Between rounds, and where the fleet is away at most.
    now
        The station's clock.
    """

    def __init__(
        self,
        push: Callable[[Stop], Pushed],
        folder: Path,
        *,
        every_s: float,
        longest_pause_s: float,
        now: Callable[[], datetime],
    ) -> None:
        self._push = push
        self._folder = folder
        self._every_s = every_s
        self._longest_pause_s = longest_pause_s
        self._now = now
        self._pause_s = _FIRST_PAUSE_S
        self._away_since: datetime | None = None
        self._note = read_note(folder) or FleetNote(since=now())

    def follow(self, stop: Stop) -> None:
        """Send until told to stop."""
        self._write()
        while not stop.is_set():
            stop.wait(self.round(stop))

    def round(self, stop: Stop) -> float:
        """Make one round; return how long to wait for the next, s.  No failure ends it."""
        try:
            pushed = self._push(stop)
        except StationError as error:
            # Told to stop while it waited, it knows nothing new of the fleet.
            return 0.0 if stop.is_set() else self._failed(str(error))
        except Exception as error:  # whatever it is, the next round may do better
            _log.exception("not sent to the fleet")
            return self._failed(f"it failed unexpectedly ({type(error).__name__})")
        self._succeeded(pushed)
        return self._every_s

    def _failed(self, why: str) -> float:
        if self._away_since is None:
            self._away_since = self._now()
            _log.warning("fleet not reached; it is tried again", why=why)
        self._note = replace(self._note, why=why)
        self._write()
        pause_s = self._pause_s
        self._pause_s = min(2.0 * pause_s, self._longest_pause_s)
        return pause_s

    def _succeeded(self, pushed: Pushed) -> None:
        now = self._now()
        if self._away_since is not None:
            away_s = round((now - self._away_since).total_seconds(), 1)
            _log.info("fleet reached again", away_s=away_s)
        self._away_since, self._pause_s = None, _FIRST_PAUSE_S
        if pushed.changes:
            told = {"changes": pushed.changes, "rows": pushed.rows, "left": pushed.left.count}
            _log.info("sent to the fleet", **told)
        self._note = replace(self._note, reached_at=now, number=pushed.number, why=None)
        self._write()

    def _write(self) -> None:
        try:
            write_note(self._folder, self._note)
        except OSError as error:
            _log.warning("fleet's note not written", why=str(error))
