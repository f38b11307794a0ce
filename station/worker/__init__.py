"""Durable jobs: the process that runs them, and the way to tell it of one."""

from station.worker.lock import held, is_held
from station.worker.queue import WorkerQueue

__all__ = ["WorkerQueue", "held", "is_held"]
