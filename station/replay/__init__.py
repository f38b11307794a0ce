"""Measuring recordings again, on all cores or on many machines, into tables."""

from station.replay.cluster import local_workers, sooner_by_workers, workers_at
from station.replay.crew import Crew, Done, Failed, Here, Workers
from station.replay.means import Means
from station.replay.report import Refusal, ReplayForecast, ReplayReport
from station.replay.run import Replay, replay_recordings
from station.replay.work import OtherSoftware, be_a_worker

__all__ = [
    "Crew",
    "Done",
    "Failed",
    "Here",
    "Means",
    "OtherSoftware",
    "Refusal",
    "Replay",
    "ReplayForecast",
    "ReplayReport",
    "Workers",
    "be_a_worker",
    "local_workers",
    "replay_recordings",
    "sooner_by_workers",
    "workers_at",
]
