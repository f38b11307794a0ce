"""Ending a recording and accounting for its frames, whatever its capture process went through."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import structlog

from station.capture import CaptureReport
from station.errors import StationError
from station.log_ids import about
from station.operations.collaborators import FileAccount, Salvaged, Station
from station.processes.threads import at_a_time
from station.store import Recording

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Closed:
    """How the frames of a recording add up once it is closed."""

    recorded: int
    lost: int
    repeated: int
    refused: int
    complete: bool
    recovered: bool
    summary: str
    files: int

    @classmethod
    def from_report(cls, report: CaptureReport) -> "Closed":
        """Take over what the capture process accounted for."""
        return cls(
            recorded=report.recorded,
            lost=report.lost,
            repeated=report.repeated,
            refused=report.refused,
            complete=report.complete,
            recovered=report.interrupted,
            files=len(report.paths),
            summary=report.summary().removeprefix(f"{report.path}: "),
        )

    @classmethod
    def from_salvage(cls, found: Salvaged | None, expected: int | None, why: str) -> "Closed":
        """Account for what a dead capture left, against the triggers counted where they are."""
        if found is not None and found.account is not None:
            return cls._from_file(found, found.account, expected)
        frames = 0 if found is None else found.frames
        return cls(
            recorded=frames,
            lost=0 if expected is None else max(expected - frames, 0),
            repeated=0,
            refused=0,
            complete=False,
            recovered=found is not None,
            files=0 if found is None else found.files,
            summary=f"{why}; {'nothing was left' if found is None else found.summary}",
        )

    @classmethod
    def _from_file(cls, found: Salvaged, said: FileAccount, expected: int | None) -> "Closed":
        """Take over what the capture had said in the file, its report having come to nobody."""
        accounted = found.frames + said.lost + said.refused
        missing = 0 if expected is None else max(expected - accounted, 0)
        return cls(
            recorded=found.frames,
            lost=said.lost + missing,
            repeated=said.repeated,
            refused=said.refused,
            complete=said.complete and expected in {None, found.frames},
            recovered=found.interruptions > 0,
            files=found.files,
            summary=f"{found.summary}, {said.lost + missing} lost, as the file itself says",
        )


def close_all(
    station: Station, recordings: Iterable[Recording], expected: Mapping[str, int | None]
) -> dict[str, Closed]:
    """End the recordings, all sensors at a time, and return their accounts by recording id."""
    todo = list(recordings)
    accounts = at_a_time(lambda one: _close(station, one, expected.get(one.sensor)), todo)
    for recording, closed in zip(todo, accounts, strict=True):
        _log_account(recording, closed)
    return {recording.id: closed for recording, closed in zip(todo, accounts, strict=True)}


def _log_account(recording: Recording, closed: Closed) -> None:
    with about(
        recording=recording.id,
        sensor=recording.sensor,
        pass_id=recording.pass_id,
        session=recording.session_id,
    ):
        say = _log.info if closed.complete else _log.warning
        say("recording closed", recorded=closed.recorded, lost=closed.lost, summary=closed.summary)


def _close(station: Station, recording: Recording, expected: int | None) -> Closed:
    # Never raises for what happened to camera, process or file: the pass ends, and says so.
    path = station.layout.root / recording.path
    capture = station.captures.get(recording.sensor)
    if capture is None:
        return _salvage(station, recording, expected, "the station no longer has the sensor")
    try:
        report = capture.finish(expected)
    except StationError as error:
        return _salvage(station, recording, expected, str(error))
    if report.path != path:
        # The capture process was restarted and armed anew since: its report is of another file.
        return _salvage(station, recording, expected, f"the sensor had gone on to {report.path}")
    return Closed.from_report(report)


def _salvage(station: Station, recording: Recording, expected: int | None, why: str) -> Closed:
    try:
        found = station.salvage(station.layout.root / recording.path)
    except StationError as error:
        return Closed.from_salvage(None, expected, f"{why}; {error}")
    return Closed.from_salvage(found, expected, why)


def note(recording: Recording, closed: Closed, expected: int | None) -> None:
    """Write into a recording's row how its frames add up."""
    recording.expected = expected
    recording.recorded = closed.recorded
    recording.lost = closed.lost
    recording.repeated = closed.repeated
    recording.refused = closed.refused
    recording.complete = closed.complete
    recording.recovered = closed.recovered
    recording.summary = closed.summary
    recording.files = closed.files


def recount(recording: Recording, expected: int) -> None:
    """Hold a closed recording against triggers that were told when it was closed already."""
    accounted = sum(count or 0 for count in (recording.recorded, recording.lost, recording.refused))
    missing = max(expected - accounted, 0)
    recording.expected = expected
    recording.lost = (recording.lost or 0) + missing
    recording.complete = bool(recording.complete) and recording.recorded == expected
    told = f"{expected} triggered, as was told later"
    if missing:
        told += f", {missing} of them without a trace"
    recording.summary = told if recording.summary is None else f"{recording.summary}; {told}"
