"""The worker process: runs the jobs until it is told to stop."""

import math
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import structlog

from station.capture import CaptureClient
from station.errors import StoreUnusable
from station.operations import Capture, DataLayout
from station.processes.lock import held
from station.processes.stop_signal import StopSignal
from station.settings import StationSettings
from station.storage import unnamed_recordings
from station.store import Store
from station.worker.context import Mathematics, WorkContext
from station.worker.following import PassFollower
from station.worker.housekeeping import order_housekeeping
from station.worker.scheduling import order_what_is_owed
from station.worker.workflows import Workflows

_SWEEP_S = 1.0
_LOOK_AT_DISK_S = 300.0
_PATIENCE_S = 10
_log = structlog.get_logger()


class Stop(Protocol):
    """Says when to stop."""

    def is_set(self) -> bool: ...

    def wait(self, timeout: float) -> bool: ...


def work(
    settings: StationSettings,
    mathematics: Mathematics,
    *,
    stop: Stop,
    captures: Mapping[str, Capture] | None = None,
) -> None:
    """Run the jobs until `stop` is set; the next worker takes up what is then unfinished."""
    layout = DataLayout.of(settings)
    store = Store.open(layout.store_url)
    context = WorkContext(settings, store, layout, mathematics, captures=captures or {})
    follower = PassFollower(context)
    context = replace(context, let_go=follower.let_go)
    workflows = Workflows(context)
    workflows.launch()
    rounds = _Rounds(context, workflows)
    # Held only from here on: whoever asks whether the worker is ready asks for the lock.
    with held(layout.worker_lock, "a worker"):
        _log.info("worker ready")
        if settings.measuring.while_recording:
            follower.start()
        while not stop.is_set():
            rounds.make()
            stop.wait(_SWEEP_S)
        follower.stop()
        workflows.stop(_PATIENCE_S)
    store.close()


@dataclass(slots=True)
class _Rounds:
    """What the worker looks after every second, beside the jobs it runs."""

    context: WorkContext
    workflows: Workflows
    looked_s: float = -math.inf
    reached: bool = True
    told: set[Path] = field(default_factory=set)
    """Recordings that the log has named already."""

    def make(self) -> None:
        """See what is to be done; a store that is away must not end the worker with its jobs."""
        try:
            self._look()
        except StoreUnusable as error:
            if self.reached:
                _log.warning("store not reached", why=str(error))
            self.reached = False
        else:
            self.reached = True

    def _look(self) -> None:
        self.workflows.take_in()
        order_what_is_owed(self.context)
        if time.monotonic() - self.looked_s >= _LOOK_AT_DISK_S:
            _look_at_disk(self.context, self.told)
            self.looked_s = time.monotonic()


def _look_at_disk(context: WorkContext, told: set[Path]) -> None:
    """Order what the disk needs, tell of what nobody knows; one that refuses ends no worker."""
    try:
        order_housekeeping(context)
        for path in unnamed_recordings(context.store, context.layout.root):
            if path not in told:
                told.add(path)
                _log.warning("recording in no row of the store; it is left alone", path=str(path))
    except OSError as error:
        _log.warning("disk not looked at", why=str(error))


def run_worker(settings: StationSettings, sockets: Mapping[str, Path]) -> None:
    """Be the worker process of a station: run its jobs until SIGTERM.

    `sockets` are those of the sensors' capture processes.
    """
    # Only the process that does the mathematics needs these.
    from station.pipeline import (  # noqa: PLC0415  as above
        calibrate_rig_sources,
        calibrate_sources,
        measure_rig,
        measure_sources,
    )
    from station.processes.one_core import use_one_core  # noqa: PLC0415  as above

    use_one_core()  # the other belongs to camera and disk
    stop = StopSignal((signal.SIGTERM,))
    mathematics = Mathematics(
        calibrate_sources, measure_sources, calibrate_rig_sources, measure_rig
    )
    captures = {sensor: CaptureClient(path) for sensor, path in sockets.items()}
    work(settings, mathematics, stop=stop, captures=captures)
