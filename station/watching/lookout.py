"""Looking at all parts of the station: soon over, however one of them hangs."""

import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextvars import Context
from datetime import datetime, timedelta
from functools import partial
from threading import Lock

import structlog

from station.capture import CaptureStatus
from station.errors import StationError
from station.fleet import read_note
from station.host_clock import ClockState, clock_state
from station.operations import Capture, Station
from station.storage import GB, expected_of_pass
from station.watching.asking import Asker, answers_of
from station.watching.outlook import Outlook, gravest_first
from station.watching.store_troubles import store_troubles
from station.watching.troubles import (
    CLOCK,
    CONTROLLER,
    DISK,
    FLEET,
    STORE,
    WORKER,
    Severity,
    Trouble,
    TroubleKind,
    part_of_rig,
    part_of_sensor,
)

_PATIENCE_S = 2.0
"""How long a look waits for a part that does not answer, once; the next look knows it hangs."""
_FRESH_S = 1.0
"""How long a look is good: a probe that asks ten times a second costs no more than one a second."""
_UNREADY_FRESH_S = 0.2
"""One that is not ready is waited for, as when the station starts."""
_FEW_PASSES = 3
_log = structlog.get_logger()

_Told = tuple[TroubleKind, str, str]
"""A trouble without its moment: kind, part, what."""


class Lookout:
    """Keeps the last look at the station, and since when what it saw is so.

    Parameters
    ----------
    worker_runs
        Tells whether a worker holds its lock.
    clock
        Tells how this host's clock is kept.
    patience_s
        How long to wait for a part at most, s.
    fresh_s
        How long a look is not repeated, s.
    """

    def __init__(
        self,
        station: Station,
        worker_runs: Callable[[], bool],
        *,
        clock: Callable[[], ClockState] = clock_state,
        patience_s: float = _PATIENCE_S,
        fresh_s: float = _FRESH_S,
    ) -> None:
        self._station = station
        self._worker_runs = worker_runs
        self._clock = clock
        self._patience_s = patience_s
        self._fresh_s = fresh_s
        self._captures = {
            sensor: Asker(f"look at {sensor}", partial(_status_of, capture))
            for sensor, capture in station.captures.items()
        }
        self._store = {STORE: Asker("look at the store", self._ask_store)}
        self._began = station.now()
        self._since: dict[tuple[TroubleKind, str], datetime] = {}
        self._last: Outlook | None = None
        self._looked_s = 0.0
        self._looking = Lock()

    def look(self) -> Outlook:
        """Return the station as it is, or was a second ago; never raises.

        While one caller waits for a part that hangs, the others are given the look before.
        """
        last = self._last
        if last is not None and self._is_fresh(last):
            return last
        if not self._looking.acquire(blocking=last is None):
            return last or self.look()
        try:
            if self._last is None or not self._is_fresh(self._last):
                self._last = self._see()
                self._looked_s = time.monotonic()
            return self._last
        finally:
            self._looking.release()

    def _is_fresh(self, last: Outlook) -> bool:
        age_s = time.monotonic() - self._looked_s
        return age_s < (self._fresh_s if last.ready else min(self._fresh_s, _UNREADY_FRESH_S))

    def _see(self) -> Outlook:
        now = self._station.now()
        known = answers_of(self._store, self._patience_s)[STORE]
        seen = answers_of(self._captures, self._patience_s)
        statuses = {
            sensor: answer for sensor, answer in seen.items() if isinstance(answer, CaptureStatus)
        }
        told = [*self._of_sensors(seen), *self._of_host(statuses), *self._of_worker()]
        told += self._of_fleet(now)
        troubles = known if isinstance(known, list) else []
        if not isinstance(known, list):
            told.append((TroubleKind.STORE_UNREACHABLE, STORE, _why(known, self._patience_s)))
        found = gravest_first([*troubles, *self._dated(told, now)])
        # In a context of its own: it has nothing to do with the call that happened to look.
        Context().run(self._log_changes, found)
        return Outlook(now, self._parts(), found, statuses)

    def _parts(self) -> list[str]:
        settings = self._station.settings
        sensors = [part_of_sensor(sensor.id) for sensor in settings.sensors]
        rigs = [part_of_rig(rig.id) for rig in settings.rigs]
        fleet = [] if settings.fleet is None else [FLEET]
        return [STORE, WORKER, *sensors, *rigs, DISK, CLOCK, CONTROLLER, *fleet]

    def _ask_store(self) -> list[Trouble]:
        station = self._station
        with station.store.look() as session:
            return list(store_troubles(session, station.settings, station.now(), self._began))

    def _of_sensors(self, seen: Mapping[str, CaptureStatus | Exception | None]) -> Iterator[_Told]:
        for sensor, answer in seen.items():
            part = part_of_sensor(sensor)
            if not isinstance(answer, CaptureStatus):
                yield TroubleKind.CAPTURE_SILENT, part, _why(answer, self._patience_s)
            elif answer.problem is not None:
                yield TroubleKind.CAMERA_LOST, part, answer.problem
            elif answer.warnings:
                yield TroubleKind.CAMERA_UNFIT, part, "; ".join(answer.warnings)

    def _of_worker(self) -> Iterator[_Told]:
        try:
            runs = self._worker_runs()
        except OSError:
            runs = False
        if not runs:
            yield TroubleKind.WORKER_STOPPED, WORKER, "no worker process runs the jobs"

    def _of_fleet(self, now: datetime) -> Iterator[_Told]:
        """Tell of a fleet only when it is away for days: nothing waits for it."""
        fleet = self._station.settings.fleet
        note = None if fleet is None else read_note(self._station.layout.root)
        if fleet is None or note is None:
            return
        last = note.reached_at or note.since
        if now - last > timedelta(days=fleet.alarm_after_days):
            why = "" if note.why is None else f": {note.why}"
            yield (
                TroubleKind.FLEET_SILENT,
                FLEET,
                f"not reached since {last:%Y-%m-%d %H:%M} UTC{why}",
            )

    def _of_host(self, statuses: Mapping[str, CaptureStatus]) -> Iterator[_Told]:
        try:
            free = shutil.disk_usage(self._station.layout.root).free
        except OSError as error:
            yield TroubleKind.DISK_UNREADABLE, DISK, f"the data folder: {error.strerror}"
        else:
            yield from self._of_space(free, statuses)
        try:
            kept = self._clock().kept
        except OSError:
            return  # a kernel that does not tell, as in some containers
        if not kept:
            what = "the host's clock is not synchronised: frames and readings may be dated wrongly"
            yield TroubleKind.CLOCK_UNKEPT, CLOCK, what

    def _of_space(self, free: int, statuses: Mapping[str, CaptureStatus]) -> Iterator[_Told]:
        storage = self._station.settings.storage
        kept = max(storage.keep_free_gb * GB, storage.reserve_mb * 1e6)
        one = sum(
            expected_of_pass(sensor, storage, _picture_bytes(statuses.get(sensor.id))).size_bytes
            for sensor in self._station.sensors
        )
        what = (
            f"{free / GB:.2f} GB free; the longest pass takes {one / GB:.2f} GB and "
            f"{kept / GB:g} GB are kept free"
        )
        if free < kept + one:
            yield TroubleKind.DISK_SHORT, DISK, what
        elif free < kept + _FEW_PASSES * one:
            yield TroubleKind.DISK_LOW, DISK, what

    def _dated(self, told: list[_Told], now: datetime) -> list[Trouble]:
        """Give each its moment: the look that saw it first, of those that saw it ever since."""
        keys = {(kind, part) for kind, part, _ in told}
        self._since = {key: self._since.get(key, now) for key in keys}
        return [Trouble(kind, part, what, self._since[kind, part]) for kind, part, what in told]

    def _log_changes(self, found: list[Trouble]) -> None:
        """Log what has come and gone since the last look, for those who read nothing else."""
        before = {} if self._last is None else {(t.kind, t.part): t for t in self._last.troubles}
        after = {(trouble.kind, trouble.part): trouble for trouble in found}
        for key in after.keys() - before.keys():
            new = after[key]
            say = _log.info if new.severity is Severity.NOTICE else _log.warning
            say("trouble", kind=new.kind.value, part=new.part, what=new.what, cure=new.cure)
        for kind, part in before.keys() - after.keys():
            _log.info("trouble over", kind=kind.value, part=part)


def _status_of(capture: Capture) -> CaptureStatus:
    return capture.status()


def _why(answer: object, patience_s: float) -> str:
    if answer is None:
        return f"no answer within {patience_s:g} s"
    if isinstance(answer, StationError):
        return str(answer)
    return f"it failed unexpectedly ({type(answer).__name__})"


def _picture_bytes(status: CaptureStatus | None) -> int | None:
    """Return the size of a camera's pictures; None where it does not say."""
    if status is None:
        return None
    try:
        return int(status.camera["width"]) * int(status.camera["height"])
    except (KeyError, ValueError):
        return None
