"""Recordings that go on though what they were made for has ended: closed, kept, listed.

A capture process that did not answer when its pass was closed goes on with it, and takes no other;
so does one that a store from a backup no longer knows of.
"""

from collections.abc import Mapping
from pathlib import Path

import structlog
from sqlalchemy import select

from station.capture import CaptureReport, CaptureState, CaptureStatus
from station.errors import StationError
from station.log_ids import about
from station.operations.closing import Closed, note
from station.operations.collaborators import Station
from station.store import STATION, Action, Recording, audit, paths_being_recorded

_GOING_ON = frozenset({CaptureState.RECORDING, CaptureState.BLIND})
_log = structlog.get_logger()


def close_strays(station: Station, statuses: Mapping[str, CaptureStatus | None]) -> list[str]:
    """Close what sensors record for nobody, as their statuses show it; return the recordings' ids.

    A sensor that cannot be asked, or does not close its file, is left for the next time.
    """
    with station.store.look() as session:
        wanted = {_absolute(station, path) for path in paths_being_recorded(session)}
    found = []
    for sensor, status in statuses.items():
        if status is None or status.path in wanted or not _goes_on(status):
            continue
        with about(sensor=sensor):
            try:
                found += _close(station, sensor, status)
            except StationError as error:
                _log.warning("stray recording not closed", path=str(status.path), why=str(error))
    return found


def _goes_on(status: CaptureStatus) -> bool:
    return status.path is not None and status.state in _GOING_ON


def _close(station: Station, sensor: str, stray: CaptureStatus) -> list[str]:
    capture = station.captures[sensor]
    now = capture.status()
    # The store was asked after the first status: what is no longer wanted then never is again, and
    # a sensor that still has it cannot have been armed for something else meanwhile.
    if now.path != stray.path or not _goes_on(now):
        return []
    report = capture.finish(None)
    root = station.layout.root.absolute()
    if not report.path.is_relative_to(root):
        _log.warning("stray recording closed, not ours to list", path=str(report.path))
        return []
    return [_keep(station, sensor, report, str(report.path.relative_to(root)), stray.session_id)]


def _keep(
    station: Station, sensor: str, report: CaptureReport, path: str, owner: str | None
) -> str:
    """Account for what was closed in the row of its recording, a new one where there is none."""
    with station.store.change() as session:
        recording = session.scalar(
            select(Recording).where(Recording.sensor == sensor).where(Recording.path == path)
        )
        if recording is None:
            recording = Recording(
                id=f"stray.{owner}.{sensor}.{station.new_id()[:8]}",
                sensor=sensor,
                path=path,
                opened_at=station.now(),
                recovered=False,
            )
            session.add(recording)
        recording.closed_at = station.now()
        note(recording, Closed.from_report(report), recording.expected)
        told = {"path": path, "recorded": report.recorded}
        by, at = STATION, station.now()
        audit(session, Action.FINISH, "recording", recording.id, by=by, at=at, after=told)
    _log.warning("stray recording closed", recording=recording.id, recorded=report.recorded)
    return recording.id


def _absolute(station: Station, path: str) -> Path:
    return (station.layout.root / path).absolute()
