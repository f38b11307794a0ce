"""Measuring recordings again, on all cores or on many machines, into tables."""

from station.replay.cluster import local_workers, workers_at
from station.replay.crew import Crew, Done, Failed, Here, Workers
from station.replay.means import Means
from station.replay.report import Refusal, ReplayForecast, ReplayReport
from station.replay.run import Replay, replay_recordings

__all__ = [
    "Crew",
    "Done",
    "Failed",
    "Here",
    "Means",
    "Refusal",
    "Replay",
    "ReplayForecast",
    "ReplayReport",
    "Workers",
    "local_workers",
    "replay_recordings",
    "workers_at",
]
