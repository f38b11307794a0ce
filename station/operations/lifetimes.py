"""Passes and sessions that go on without their controller: looked after once a second."""

import time
from collections.abc import Callable, Iterable, Mapping

import structlog

from station.capture import CaptureStatus
from station.errors import StationError
from station.log_ids import about
from station.operations.collaborators import Capture, Station
from station.operations.hearing import Heard, Hearing
from station.operations.overdue import why_pass_overdue, why_session_overdue
from station.operations.passes import Passes
from station.operations.rejoining import is_idle
from station.operations.session_orders import SessionView, session_view
from station.operations.sessions import Sessions
from station.operations.strays import close_strays
from station.operations.views import PassView, view_of
from station.processes.threads import at_a_time
from station.store import PassState, Recording, SessionState, open_sessions, passes_held

_STUCK_S = 120.0
"""The worker opens sessions too: only what takes longer than any arming or closing is stuck."""
_log = structlog.get_logger()

Statuses = Mapping[str, CaptureStatus | None]
"""What each sensor's capture process tells; None where it does not."""


class Lifetimes:
    """Ends what is overdue, goes on with what stopped in the middle, closes what nobody wants."""

    def __init__(
        self,
        station: Station,
        passes: Passes,
        sessions: Sessions,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._station = station
        self._passes = passes
        self._sessions = sessions
        self._clock = clock
        self._hearing = Hearing(clock)
        self._stuck_since_s: dict[str, float] = {}

    def look(self) -> None:
        """Do what is due now.

        Raises
        ------
        StoreUnusable
            If the store does not answer; the next look does what is then due.
        """
        with self._station.store.look() as session:
            passes = [view_of(session, row.id) for row in passes_held(session)]
            sessions = [session_view(session, row) for row in open_sessions(session)]
        statuses = self._statuses()
        for view in passes:
            with about(pass_id=view.row.id):
                self._look_at_pass(view, statuses)
        for each in sessions:
            with about(session=each.row.id):
                self._look_at_session(each, statuses)
        close_strays(self._station, statuses)
        names = {_name(view) for view in passes} | {_name(each) for each in sessions}
        self._hearing.forget_all_but(names)
        self._stuck_since_s = {n: s for n, s in self._stuck_since_s.items() if n in names}

    def _look_at_pass(self, view: PassView, statuses: Statuses) -> None:
        row = view.row
        heard = self._listen(view, statuses)
        if row.state is PassState.ARMED or row.ended_by is not None:
            self._passes.bring_on(row.id)
            return
        limits = self._station.settings.controller
        why = why_pass_overdue(heard, limits, self._station.now())
        if why is None:
            self._rejoin_idle(view, statuses)
        elif self._passes.end_overdue(row.id, why):
            _log.warning("pass ended by itself", why=why)

    def _rejoin_idle(self, view: PassView, statuses: Statuses) -> None:
        if any(is_idle(statuses.get(each.sensor)) for each in view.recordings):
            self._passes.rejoin(view.row.id, statuses)

    def _look_at_session(self, view: SessionView, statuses: Statuses) -> None:
        row = view.row
        heard = self._listen(view, statuses)
        if row.state is SessionState.ARMED or row.ended_by is not None:
            since_s = self._stuck_since_s.setdefault(_name(view), self._clock())
            if self._clock() - since_s >= _STUCK_S:
                self._sessions.bring_on(row.id)
            return
        limits = self._station.settings.controller
        why = why_session_overdue(heard, limits, self._station.now())
        if why is not None and self._sessions.end_overdue(row.id, why):
            _log.warning("calibration session ended by itself", why=why)

    def _listen(self, view: PassView | SessionView, statuses: Statuses) -> Heard:
        return self._hearing.listen(
            _name(view),
            _recording_it(view.row.id, view.recordings, statuses),
            opened_at=view.row.opened_at,
            now=self._station.now(),
        )

    def _statuses(self) -> Statuses:
        captures = self._station.captures
        told = at_a_time(_status, captures.values())
        return dict(zip(captures, told, strict=True))


def _recording_it(owner: str, recordings: Iterable[Recording], statuses: Statuses) -> Statuses:
    told = {each.sensor: statuses.get(each.sensor) for each in recordings}
    return {
        sensor: status if status is not None and status.session_id == owner else None
        for sensor, status in told.items()
    }


def _status(capture: Capture) -> CaptureStatus | None:
    try:
        return capture.status()
    except StationError:
        return None


def _name(view: PassView | SessionView) -> str:
    return f"{view.row.__tablename__}.{view.row.id}"
