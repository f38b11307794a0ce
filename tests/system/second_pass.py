"""A train goes by a station once more: its cameras show the pictures of the first time."""

import os
import secrets
import subprocess
import sys
import time
import tomllib
from contextlib import ExitStack, contextmanager

import numpy as np

from station.client import StationClient
from station.demo.rendering import RenderedFrames
from station.demo.trackside import roll_train_by
from station.recording import frames
from station.simulated import SimulatedCameraProcess

READY_S = 240.0


def pass_again(folder, pass_id, recordings):
    """Serve the station that `folder` was left by, and let each camera show a recording again.

    `recordings` are by sensor. All cameras are triggered together, as those of a rig must be.
    Return the wheels that the API gives for the new pass.
    """
    config = folder / "station.toml"
    settings = tomllib.loads(config.read_text())
    key = secrets.token_urlsafe(32)
    with ExitStack() as stack:
        cameras = {
            sensor["id"]: stack.enter_context(_camera(folder, sensor, recordings[sensor["id"]]))
            for sensor in settings["sensors"]
        }
        environment = {**os.environ, "STATION_ADMIN_KEY": key}
        log = stack.enter_context((folder / "second.log").open("wb"))
        stack.enter_context(_process("serve", "--config", config, stderr=log, env=environment))
        url = f"http://127.0.0.1:{settings['port']}"
        client = stack.enter_context(StationClient.connect(url, key))
        _await_ready(client)
        client.arm_pass(pass_id)
        closed = client.finish_pass(pass_id, triggers=roll_train_by(cameras))
        assert all(recording["complete"] for recording in closed["recordings"]), closed
        client.await_pass(pass_id, timeout_s=READY_S)
        return client.wheels(pass_id)


def _camera(folder, sensor, recording):
    pictures = folder / f"again-{sensor['id']}.npy"
    np.save(pictures, [frame.picture for frame in frames(recording, sensor["id"])])
    return SimulatedCameraProcess(sensor["address"], RenderedFrames(pictures), serial=sensor["id"])


@contextmanager
def _process(*arguments, stdout=subprocess.DEVNULL, **options):
    command = [sys.executable, "-m", "station", *map(str, arguments)]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, **options) as process:
        try:
            yield process
        finally:
            process.terminate()


def _await_ready(client):
    deadline = time.monotonic() + READY_S
    while not client.ready():
        assert time.monotonic() < deadline, "the station did not get ready"
        time.sleep(0.1)
