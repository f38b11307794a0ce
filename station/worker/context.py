"""What the jobs work with; tests give their own mathematics."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Protocol

from calib import CameraModel, Method, Target
from measure import Limits
from station.documents import CalibrationDocument, MeasurementDocument, RigDocument
from station.operations import Capture, DataLayout, utc_now
from station.pipeline import CalibrationOutcome, Cores, Resumption, RigOrder, RigOutcome
from station.progress import Progress
from station.settings import MountingSettings, StationSettings
from station.store import Store


class CalibrateSources(Protocol):
    """From recordings of a target to a calibration."""

    def __call__(
        self,
        sources: Sequence[Path],
        target: Target,
        *,
        sensor: str,
        method: Method,
        laser_off: Sequence[Path],
        mounting: MountingSettings | None,
        progress: Progress,
        camera: CameraModel | None = None,
    ) -> CalibrationOutcome: ...


class MeasureSources(Protocol):
    """From recordings of wheels to readings."""

    def __call__(
        self,
        sources: Sequence[Path],
        calibration: CalibrationDocument,
        *,
        reference: str,
        limits: Limits,
        progress: Progress,
        since: Resumption | None = None,
        cores: Cores | None = None,
    ) -> MeasurementDocument: ...


class CalibrateRig(Protocol):
    """From recordings of a rigid target to a rig."""

    def __call__(
        self, sources: Sequence[Path], order: RigOrder, *, progress: Progress
    ) -> RigOutcome: ...


class MeasureRig(Protocol):
    """From the recordings of a rig's sensors to readings."""

    def __call__(
        self,
        sources: Mapping[str, Path],
        rig: RigDocument,
        *,
        calibrations: Sequence[CalibrationDocument],
        silent_sensors: Mapping[str, str],
        all_sound: bool,
        max_skew_us: float,
        reference: str,
        limits: Limits,
        progress: Progress,
        since: Resumption | None = None,
        cores: Cores | None = None,
    ) -> MeasurementDocument: ...


@dataclass(frozen=True, slots=True)
class Mathematics:
    """What the worker calculates with."""

    calibrate: CalibrateSources
    measure: MeasureSources
    calibrate_rig: CalibrateRig
    measure_rig: MeasureRig


def _not_followed(_pass_id: str) -> None:
    """Let a pass go that nobody follows."""


@dataclass(frozen=True, slots=True)
class WorkContext:
    """The parts of the station that its jobs use."""

    settings: StationSettings
    store: Store
    layout: DataLayout
    mathematics: Mathematics
    now: Callable[[], datetime] = utc_now
    captures: Mapping[str, Capture] = field(default_factory=dict)
    """The sensors' capture processes; none where the station does not run."""
    let_go: Callable[[str], None] = _not_followed
    """Ends measuring a pass while it is recorded, by its id, so that it can be measured whole."""
