"""The driver and the recorder: frames from the camera into a recording, each accounted for."""

from station.capture.client import CaptureClient, start_capture
from station.capture.interruption import Interruption
from station.capture.look import Look
from station.capture.plan import CaptureReport, ExposureStep, RecordingPlan, Trigger
from station.capture.status import CaptureState, CaptureStatus

__all__ = [
    "CaptureClient",
    "CaptureReport",
    "CaptureState",
    "CaptureStatus",
    "ExposureStep",
    "Interruption",
    "Look",
    "RecordingPlan",
    "Trigger",
    "start_capture",
]
