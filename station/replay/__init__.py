"""Measuring recordings again, on all cores, into one table."""

from station.replay.report import Refusal, ReplayReport
from station.replay.run import replay_recordings

__all__ = ["Refusal", "ReplayReport", "replay_recordings"]
