"""What the operations need from the rest of the station; tests give their own."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Protocol
from uuid import uuid4

from station.capture import CaptureReport, CaptureStatus, Look, RecordingPlan
from station.operations.layout import DataLayout
from station.settings import SensorSettings, StationSettings
from station.store import JobKind, Store


class Capture(Protocol):
    """One sensor's capture process, as its client shows it."""

    def status(self) -> CaptureStatus: ...

    def arm(self, plan: RecordingPlan) -> None: ...

    def trigger(self) -> int: ...

    def finish(self, expected_frames: int | None = None) -> CaptureReport: ...

    def look(self) -> Look: ...


class JobQueue(Protocol):
    """The way to the worker process."""

    def submit(self, kind: JobKind, job_id: str) -> None:
        """Tell the worker of a job; it does not matter if it is told twice or never."""

    def cancel(self, job_id: str) -> None:
        """Tell the worker not to begin, or not to go on with, a job."""


@dataclass(frozen=True, slots=True)
class Salvaged:
    """What was left of a recording whose capture died."""

    frames: int
    summary: str
    files: int = 1
    account: "FileAccount | None" = None
    """Where the capture had finished the recording and said in it how its frames add up."""
    interruptions: int = 0
    """How often another capture process had gone on with it."""
    last_frame_id: int | None = None
    """Of the last frame; None where there is none, or it cannot be read."""
    last_frame_ns: int | None = None
    """When that was received, UTC."""


@dataclass(frozen=True, slots=True)
class FileAccount:
    """What a finished recording says of frames that are not in it."""

    triggered: int | None
    lost: int
    repeated: int
    refused: int
    complete: bool


Salvage = Callable[[Path], Salvaged | None]
"""Makes whole what a dead capture left under the path; None where it left nothing."""


def utc_now() -> datetime:
    """Return the time by the host's clock."""
    return datetime.now(UTC)


def random_id() -> str:
    """Return a name that nobody has had."""
    return uuid4().hex


@dataclass(frozen=True, slots=True)
class Station:
    """The parts of a running station that operations work with."""

    settings: StationSettings
    store: Store
    layout: DataLayout
    captures: Mapping[str, Capture]
    jobs: JobQueue
    salvage: Salvage
    now: Callable[[], datetime] = utc_now
    new_id: Callable[[], str] = random_id

    @property
    def sensors(self) -> tuple[SensorSettings, ...]:
        """The sensors, one or more."""
        return self.settings.sensors
