"""What the station's processes do when they start; each runs as a process of its own."""

import os
import signal
import socket
from functools import partial
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

from station.capture import start_capture
from station.operations import DataLayout
from station.processes.beginning import begin_process
from station.processes.lifeline import end_with_parent
from station.processes.priority import answer_promptly, yield_to_others
from station.serve.sockets import socket_path
from station.settings import LogLevel, SensorSettings, StationSettings
from station.worker import run_worker

_SPAWN = get_context("spawn")  # never fork: Aravis and SQLite do not survive it


def start_sensor(sensor: SensorSettings, settings: StationSettings, run_dir: Path) -> BaseProcess:
    """Start the capture process of a sensor; it notices by itself when its parent dies."""
    begin = partial(begin_process, f"capture {sensor.id}", *_known(settings))
    return start_capture(sensor, socket_path(run_dir, sensor.id), log=begin)


def start_api(
    settings: StationSettings, run_dir: Path, listening: socket.socket, admin_key: str | None
) -> BaseProcess:
    """Start the API process on a socket that listens already."""
    process = _SPAWN.Process(
        target=_run_api, args=(settings, run_dir, listening, admin_key, os.getpid()), name="api"
    )
    process.start()
    return process


def start_worker(settings: StationSettings, run_dir: Path) -> BaseProcess:
    """Start the worker process."""
    sockets = {sensor.id: socket_path(run_dir, sensor.id) for sensor in settings.sensors}
    process = _SPAWN.Process(
        target=_run_worker, args=(settings, sockets, os.getpid()), name="worker"
    )
    process.start()
    return process


def start_fleet(settings: StationSettings) -> BaseProcess:
    """Start the process that sends to the fleet."""
    # Its own module is what the process loads: this one would bring cameras and jobs along.
    from station.fleet import FleetPlaces, begin_fleet  # noqa: PLC0415  few stations have one

    layout = DataLayout.of(settings)
    places = FleetPlaces(layout.store_url, layout.root, layout.processes_lock)
    process = _SPAWN.Process(target=begin_fleet, args=(settings, places, os.getpid()), name="fleet")
    process.start()
    return process


def _known(settings: StationSettings) -> tuple[LogLevel, Path]:
    return settings.log_level, DataLayout.of(settings).processes_lock


def _run_worker(settings: StationSettings, sockets: dict[str, Path], supervisor_pid: int) -> None:
    end_with_parent(supervisor_pid)
    # Ctrl-C at a terminal reaches every process; in which order they end is the supervisor's.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    begin_process("worker", *_known(settings))
    yield_to_others()
    run_worker(settings, sockets)


def _run_api(
    settings: StationSettings,
    run_dir: Path,
    listening: socket.socket,
    admin_key: str | None,
    supervisor_pid: int,
) -> None:
    end_with_parent(supervisor_pid)  # before what takes seconds to import
    import uvicorn  # noqa: PLC0415  only this process pays for it

    from station.serve.assembly import assemble_api  # noqa: PLC0415  as above
    from station.serve.web import server_config  # noqa: PLC0415  as above

    begin_process("api", *_known(settings))
    app = assemble_api(settings, run_dir, admin_key=admin_key)
    answer_promptly()
    uvicorn.Server(server_config(app, settings)).run(sockets=[listening])
