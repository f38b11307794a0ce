"""The worker process: runs the jobs until it is told to stop."""

import math
import signal
import time
from typing import Protocol

import structlog

from station.operations import DataLayout
from station.processes.stop_signal import StopSignal
from station.settings import StationSettings
from station.storage import tidy
from station.store import Store
from station.worker.context import CalibrateSources, MeasureSources, WorkContext
from station.worker.lock import held
from station.worker.workflows import Workflows

_SWEEP_S = 1.0
_TIDY_S = 300.0
_PATIENCE_S = 10
_log = structlog.get_logger()


class Stop(Protocol):
    """Says when to stop."""

    def is_set(self) -> bool: ...

    def wait(self, timeout: float) -> bool: ...


def work(
    settings: StationSettings,
    *,
    calibrate: CalibrateSources,
    measure: MeasureSources,
    stop: Stop,
) -> None:
    """Run the jobs until `stop` is set; the next worker takes up what is then unfinished."""
    layout = DataLayout(settings.data_dir)
    store = Store.open(layout.store_url)
    context = WorkContext(settings, store, layout, calibrate, measure)
    workflows = Workflows(context)
    workflows.launch()
    tidied_s = -math.inf
    # Held only from here on: whoever asks whether the worker is ready asks for the lock.
    with held(layout.worker_lock, "a worker"):
        _log.info("worker ready")
        while not stop.is_set():
            workflows.take_in()
            if time.monotonic() - tidied_s >= _TIDY_S:
                _tidy(context)
                tidied_s = time.monotonic()
            stop.wait(_SWEEP_S)
        workflows.stop(_PATIENCE_S)
    store.close()


def _tidy(context: WorkContext) -> None:
    """Delete what is to make way; a disk that refuses must not end the worker."""
    try:
        tidy(context.store, context.layout.root, context.settings.storage, context.now())
    except OSError as error:
        _log.warning("disk not tidied", why=str(error))


def run_worker(settings: StationSettings) -> None:
    """Be the worker process of a station: run its jobs until SIGTERM."""
    # Only the process that does the mathematics needs these.
    from station.pipeline import calibrate_sources, measure_sources  # noqa: PLC0415  as above
    from station.processes.one_core import use_one_core  # noqa: PLC0415  as above

    use_one_core()  # the other belongs to camera and disk
    stop = StopSignal((signal.SIGTERM,))
    work(settings, calibrate=calibrate_sources, measure=measure_sources, stop=stop)
