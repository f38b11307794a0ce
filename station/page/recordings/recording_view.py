"""One recording: what it is of, how its frames add up, its files, and what was measured from it."""

from dataclasses import dataclass
from typing import Any

from sqlalchemy.orm import Session

from station.operations import Station
from station.page.recordings.condition import Condition, condition_of, missing_in
from station.page.recordings.list_view import files_on_disk
from station.page.recordings.wheels import Wheel, own_readings, wheels_in
from station.store import Job, JobState, Pass, Recording, Replay, the
from station.store.disposal import recordings_in_use
from station.store.measured import places_of
from station.store.recordings_found import measured_from, measured_together_with, replays_of

_THUMBNAILS = 16


@dataclass(frozen=True, slots=True)
class File:
    """A file of a recording."""

    number: int
    """From 1."""
    size_bytes: int


@dataclass(frozen=True, slots=True)
class OrderedReplay:
    """A replay of the recording, and where it stands."""

    row: Replay
    state: JobState
    calibration: str
    """What the recording's own sensor was measured with, where it was measured alone."""
    rig_calibration: str | None
    """What it was measured with together with others."""


@dataclass(frozen=True, slots=True)
class RecordingPage:
    """What the page of a recording shows."""

    row: Recording
    condition: Condition
    missing: int
    train: str | None
    files: tuple[File, ...]
    wheels: tuple[Wheel, ...]
    replays: tuple[OrderedReplay, ...]
    in_use: bool
    """An uploaded one that must not be deleted now."""

    @property
    def size_bytes(self) -> int | None:
        """Of all of its files; None without any."""
        return sum(file.size_bytes for file in self.files) if self.files else None

    @property
    def frames(self) -> int:
        """How many frames there are to see."""
        return (self.row.recorded or 0) if self.files and self.row.closed_at is not None else 0

    @property
    def marks(self) -> list[dict[str, Any]]:
        """What the time line marks the wheels by."""
        return [wheel.marked() for wheel in self.wheels]

    @property
    def thumbnails(self) -> tuple[int, ...]:
        """Numbers of frames that stand for all, spread evenly from the first to the last."""
        return spread(self.frames, _THUMBNAILS)


def spread(count: int, most: int) -> tuple[int, ...]:
    """Return at most `most` of the numbers from 1 to `count`, evenly spread, the ends among them.

    >>> spread(3, 16), spread(100, 4), spread(0, 4)
    ((1, 2, 3), (1, 34, 67, 100), ())
    """
    if count <= most:
        return tuple(range(1, count + 1))
    return tuple(1 + place * (count - 1) // (most - 1) for place in range(most))


def recording_page(station: Station, recording_id: str) -> RecordingPage:
    """Return what the page of a recording shows; no file of it is opened.

    Raises
    ------
    NotFound
        If the station knows no such recording.
    """
    with station.store.look() as session:
        row = the(session, Recording, recording_id)
        owner = None if row.pass_id is None else session.get(Pass, row.pass_id)
        wheels = _wheels(session, row)
        replays = tuple(_ordered(session, each, row) for each in replays_of(session, row.id))
        in_use = row.sha256 is not None and row.id in recordings_in_use(session)
    files = enumerate(files_on_disk(station, row), start=1)
    return RecordingPage(
        row=row,
        condition=condition_of(row),
        missing=missing_in(row),
        train=None if owner is None else owner.train,
        files=tuple(File(number, path.stat().st_size) for number, path in files),
        wheels=wheels,
        replays=replays,
        in_use=in_use,
    )


def wheel_frames(session: Session, recording_id: str) -> list[int]:
    """Return the frames that a recording's wheels are marked by, as the camera numbers them."""
    wheels = _wheels(session, the(session, Recording, recording_id))
    return sorted({frame for each in wheels if each.own for frame in _marks(each)})


def _marks(wheel: Wheel) -> tuple[int, int, int]:
    return wheel.row.frame, wheel.frames[0], wheel.frames[-1]


def _wheels(session: Session, row: Recording) -> tuple[Wheel, ...]:
    together = measured_together_with(session, row)
    measured = own_readings(row, measured_from(session, row.id), together)
    return wheels_in(row, measured, places_of(session, measured))


def _ordered(session: Session, replay: Replay, row: Recording) -> OrderedReplay:
    job = the(session, Job, replay.job_id)
    own = replay.calibrations[row.sensor]
    return OrderedReplay(replay, job.state, own, replay.rig_calibration_id)
