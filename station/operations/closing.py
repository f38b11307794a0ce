"""Ending a recording and accounting for its frames, whatever its capture process went through."""

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from station.capture import CaptureReport
from station.errors import StationError
from station.operations.collaborators import Salvaged, Station
from station.store import Recording


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
            recovered=False,
            files=len(report.paths),
            summary=report.summary().removeprefix(f"{report.path}: "),
        )

    @classmethod
    def from_salvage(cls, found: Salvaged | None, expected: int | None, why: str) -> "Closed":
        """Account for what a dead capture left, against the triggers counted where they are."""
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


def close_all(
    station: Station, recordings: Iterable[Recording], expected: Mapping[str, int | None]
) -> dict[str, Closed]:
    """End the recordings, all sensors at a time, and return their accounts by recording id."""
    todo = list(recordings)
    with ThreadPoolExecutor(max_workers=len(todo)) as pool:
        accounts = pool.map(lambda one: _close(station, one, expected.get(one.sensor)), todo)
        return {recording.id: closed for recording, closed in zip(todo, accounts, strict=True)}


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
