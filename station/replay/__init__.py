"""Measuring recordings again, on all cores or on many machines, into tables."""

from station.replay.means import Means
from station.replay.report import Refusal, ReplayForecast, ReplayReport
from station.replay.run import Replay, replay_recordings

__all__ = [
    "Means",
    "Refusal",
    "Replay",
    "ReplayForecast",
    "ReplayReport",
    "replay_recordings",
]
