"""A train goes by a station once more: its cameras play the recordings of the first time."""

import os
import secrets
import subprocess
import sys
import time
import tomllib
from contextlib import ExitStack, contextmanager

from station.client import StationClient
from station.recording import info

READY_S = 60.0


def pass_again(folder, pass_id, recordings):
    """Serve the station that `folder` was left by, and let cameras play a recording each.

    `recordings` are by sensor. Return the wheels that the API gives for the new pass.
    """
    config = folder / "station.toml"
    settings = tomllib.loads(config.read_text())
    key = secrets.token_urlsafe(32)
    with ExitStack() as stack:
        for sensor in settings["sensors"]:
            path = recordings[sensor["id"]]
            arguments = ["camera", "simulate", "--address", sensor["address"], "--from", path]
            camera = stack.enter_context(_process(*arguments, "--once", stdout=subprocess.PIPE))
            assert b"its own timing" in camera.stdout.readline()
        environment = {**os.environ, "STATION_ADMIN_KEY": key}
        log = stack.enter_context((folder / "second.log").open("wb"))
        stack.enter_context(_process("serve", "--config", config, stderr=log, env=environment))
        url = f"http://127.0.0.1:{settings['port']}"
        client = stack.enter_context(StationClient.connect(url, key))
        _await_ready(client)
        client.arm_pass(pass_id)
        closed = client.finish_pass(pass_id, triggers=_frames_in(recordings))
        assert all(recording["complete"] for recording in closed["recordings"]), closed
        client.await_pass(pass_id, timeout_s=READY_S)
        return client.wheels(pass_id)


def _frames_in(recordings):
    return {sensor: info(path).sensors[0].frames for sensor, path in recordings.items()}


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
