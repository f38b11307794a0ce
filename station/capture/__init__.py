"""The driver and the recorder: frames from the camera into a recording, each accounted for."""

from pathlib import Path
from typing import TYPE_CHECKING

from station.capture.client import CaptureClient, start_capture
from station.capture.plan import CaptureReport, ExposureStep, RecordingPlan, Trigger
from station.capture.status import CaptureState, CaptureStatus

if TYPE_CHECKING:  # pydantic would make a new recorder late by a quarter of a second
    from station.settings import SensorSettings

__all__ = [
    "CaptureClient",
    "CaptureReport",
    "CaptureState",
    "CaptureStatus",
    "ExposureStep",
    "RecordingPlan",
    "Trigger",
    "run_capture",
    "start_capture",
]


def run_capture(settings: "SensorSettings", socket_path: Path) -> None:
    """Be the capture process of one sensor, until told to end; loads Aravis."""
    from station.capture.process import run_capture as run  # noqa: PLC0415  see the line above

    run(settings, socket_path)
