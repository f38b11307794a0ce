"""Recordings: MCAP files of pictures and events, written so that no crash loses what they hold."""

from station.recording.activefile import ACTIVE, active_path
from station.recording.events import LOSSES, Event, EventKind
from station.recording.frame_ids import id_after, ids_skipped
from station.recording.info import RecordingInfo, SensorInfo, info
from station.recording.reader import RecordedFrame, attachment, events, frames
from station.recording.recover import RecoveryReport, recover
from station.recording.verify import VerifyReport, verify
from station.recording.writer import RecordingSummary, RecordingWriter

__all__ = [
    "ACTIVE",
    "LOSSES",
    "Event",
    "EventKind",
    "RecordedFrame",
    "RecordingInfo",
    "RecordingSummary",
    "RecordingWriter",
    "RecoveryReport",
    "SensorInfo",
    "VerifyReport",
    "active_path",
    "attachment",
    "events",
    "frames",
    "id_after",
    "ids_skipped",
    "info",
    "recover",
    "verify",
]
