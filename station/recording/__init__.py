"""Recordings: MCAP files of pictures and events, written so that no crash loses what they hold."""

from station.recording.activefile import ACTIVE, active_path
from station.recording.blocks import FrameBlock, frame_blocks
from station.recording.browsing import ListedFrame, list_frames
from station.recording.camera_numbers import CameraNumbers
from station.recording.compaction import CompactReport, compact, is_compact
from station.recording.events import LOSSES, Event, EventKind
from station.recording.frame_ids import id_after, ids_skipped
from station.recording.frame_table import FrameTable
from station.recording.growing import GrowingRecording
from station.recording.info import RecordingInfo, SensorInfo, info
from station.recording.parts import (
    ACCOUNTING,
    CONTINUED_IN,
    left_behind,
    part_path,
    parts_of,
    whole_recordings,
)
from station.recording.places import BEGINNING, FilePlace, has_place, parts_from
from station.recording.reader import RecordedFrame, attachment, events, frames
from station.recording.recover import RecoveryReport, recover
from station.recording.rotating import PartsSummary, RotatingWriter
from station.recording.rotation import Rotation
from station.recording.verify import VerifyReport, verify
from station.recording.writer import RecordingSummary, RecordingWriter

__all__ = [
    "ACCOUNTING",
    "ACTIVE",
    "CONTINUED_IN",
    "LOSSES",
    "BEGINNING",
    "CameraNumbers",
    "CompactReport",
    "Event",
    "EventKind",
    "FilePlace",
    "FrameBlock",
    "FrameTable",
    "ListedFrame",
    "GrowingRecording",
    "PartsSummary",
    "RecordedFrame",
    "RecordingInfo",
    "RecordingSummary",
    "RecordingWriter",
    "RecoveryReport",
    "RotatingWriter",
    "Rotation",
    "SensorInfo",
    "VerifyReport",
    "active_path",
    "attachment",
    "compact",
    "events",
    "frame_blocks",
    "frames",
    "has_place",
    "id_after",
    "ids_skipped",
    "info",
    "is_compact",
    "left_behind",
    "list_frames",
    "part_path",
    "parts_from",
    "parts_of",
    "recover",
    "verify",
    "whole_recordings",
]
