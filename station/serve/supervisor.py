"""`station serve`: all processes of the station under one roof, until it is told to stop."""

import os
import select
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import structlog

from station.operations import DataLayout
from station.processes.stop_signal import StopSignal
from station.processes.tally import write_tally
from station.serve.certificate import ensure_tls_usable
from station.serve.children import Child, Handle
from station.serve.first_key import Say, ensure_first_key
from station.serve.listening import listen, url_of
from station.serve.processes import start_api, start_fleet, start_sensor, start_worker
from station.serve.readiness import Announce, begin_announcing
from station.serve.remains import await_end_of_killed, folder_of_sockets
from station.serve.service_manager import ServiceManager
from station.settings import StationSettings
from station.store import ensure_sound, migrate
from station.store.callers import ensure_unguessable
from station.worker import held

_API_PATIENCE_S = 8.0
_CAPTURE_PATIENCE_S = 20.0
_WORKER_PATIENCE_S = 15.0
_FLEET_PATIENCE_S = 10.0
_log = structlog.get_logger()


def supervise(
    settings: StationSettings, *, admin_key: str | None, say: Say, announce: Announce
) -> None:
    """Run the station until SIGTERM or SIGINT.

    Parameters
    ----------
    admin_key
        A key that is good besides those of the store; without it the first start makes one and
        says it once.
    say
        Where a line for people goes.
    announce
        Called with URL and seconds since the start, once every part is ready.

    Raises
    ------
    InputUnusable
        If the port is in use, the data folder or the certificate cannot be used, or the key is too
        short.
    StateConflict
        If a station runs already on this data folder, or one that was killed does not end.
    StoreUnusable
        If the store is damaged or out of reach.
    """
    if admin_key is not None:
        ensure_unguessable(admin_key)
    ensure_tls_usable(settings.tls)
    layout = DataLayout.of(settings)
    layout.ensure()
    with held(layout.station_lock, "a station"):
        await_end_of_killed(layout)
        with listen(settings.host, settings.port) as listening:
            ensure_sound(layout.store_url)
            migrate(layout.store_url)
            if admin_key is None:
                ensure_first_key(layout, say, to_a_person=sys.stderr.isatty())
            with folder_of_sockets(layout) as run_dir:
                stop = StopSignal()
                manager = ServiceManager.of(os.environ)
                begin_announcing(url_of(listening, settings.tls), announce, stop, manager)
                start_the_api = partial(start_api, settings, run_dir, listening, admin_key)
                note = partial(_note_restarts, layout.restarts_note)
                _run(_stages(settings, run_dir, start_the_api), stop, note, manager)


Stages = Sequence[Sequence[Child]]


def _stages(
    settings: StationSettings, run_dir: Path, start_the_api: Callable[[], Handle]
) -> Stages:
    """Return the processes in the stages in which they end: first who gives the cameras orders."""
    captures = [
        Child(
            f"capture {sensor.id}",
            partial(start_sensor, sensor, settings, run_dir),
            _CAPTURE_PATIENCE_S,
        )
        for sensor in settings.sensors
    ]
    worker = Child("worker", partial(start_worker, settings, run_dir), _WORKER_PATIENCE_S)
    api = Child("api", start_the_api, _API_PATIENCE_S)
    fleet = [Child("fleet", partial(start_fleet, settings), _FLEET_PATIENCE_S)]
    return [api, worker, *(fleet if settings.fleet is not None else [])], captures


def _run(
    stages: Stages,
    stop: StopSignal,
    note: Callable[[Sequence[Child]], None],
    manager: ServiceManager,
) -> None:
    """Keep the processes running until the signal; then end them stage by stage.

    `note` is called at the start, and whenever a process may have been started again.
    """
    children = [child for stage in stages for child in stage]
    try:
        for child in reversed(children):
            if not stop.is_set():
                child.start()
        while not stop.is_set():
            manager.tell_alive()
            note(children)
            _wait(children, stop, manager.sign_every_s)
            for child in children:
                child.mend()
    finally:
        manager.tell_ending()
        for stage in stages:
            for child in stage:
                child.ask_to_end()
            for child in stage:
                child.ensure_ended()
        _log.info("station stopped")


def _note_restarts(path: Path, children: Sequence[Child]) -> None:
    """Tell the API how often each was started again; a full disk is no reason to end."""
    try:
        write_tally(path, {child.name: child.restarts for child in children})
    except OSError as error:
        _log.warning("restarts not noted", why=str(error))


def _wait(children: Sequence[Child], stop: StopSignal, longest_s: float | None) -> None:
    """Sleep until a process ends, one is due to start again, the signal comes, or for so long."""
    due_s = [due for child in children if (due := child.due_s()) is not None]
    due_s += [] if longest_s is None else [longest_s]
    ends = [child.pidfd for child in children if child.pidfd is not None]
    select.select([*ends, stop.readable], [], [], min(due_s, default=None))
