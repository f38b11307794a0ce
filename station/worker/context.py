"""What the jobs work with; tests give their own mathematics."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Protocol

from calib import Method, Target
from measure import Limits
from station.documents import CalibrationDocument, MeasurementDocument
from station.operations import DataLayout, utc_now
from station.pipeline import CalibrationOutcome
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
    ) -> MeasurementDocument: ...


@dataclass(frozen=True, slots=True)
class WorkContext:
    """The parts of the station that its jobs use."""

    settings: StationSettings
    store: Store
    layout: DataLayout
    calibrate: CalibrateSources
    measure: MeasureSources
    now: Callable[[], datetime] = utc_now
