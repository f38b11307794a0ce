"""Durable jobs: the process that runs them, and the way to tell it of one."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from station.processes.lock import held, is_held
from station.settings import StationSettings
from station.store import Recalibration
from station.worker.queue import WorkerQueue

__all__ = ["WorkerQueue", "held", "is_held", "recalibrate_here", "run_worker"]


def run_worker(settings: StationSettings, sockets: Mapping[str, Path]) -> None:
    """Be the worker process of a station; loads the engine and the mathematics."""
    from station.worker.process import run_worker as run  # noqa: PLC0415  see the line above

    run(settings, sockets)


def recalibrate_here(
    settings: StationSettings,
    sensor: str | None,
    *,
    new_id: Callable[[], str],
    say: Callable[[str], None],
) -> Sequence[Recalibration]:
    """Recalibrate without a running station; loads the mathematics."""
    from station.worker.here import recalibrate_here as here  # noqa: PLC0415  see the line above

    return here(settings, sensor, new_id=new_id, say=say)
