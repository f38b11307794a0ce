"""Durable jobs: the process that runs them, and the way to tell it of one."""

from collections.abc import Mapping
from pathlib import Path

from station.settings import StationSettings
from station.worker.lock import held, is_held
from station.worker.queue import WorkerQueue

__all__ = ["WorkerQueue", "held", "is_held", "run_worker"]


def run_worker(settings: StationSettings, sockets: Mapping[str, Path]) -> None:
    """Be the worker process of a station; loads the engine and the mathematics."""
    from station.worker.process import run_worker as run  # noqa: PLC0415  see the line above

    run(settings, sockets)
