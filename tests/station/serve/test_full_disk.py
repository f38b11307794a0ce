"""A disk that fills up while a train goes by: a real one of a few megabytes, with all on it.

The service runs in a mount namespace of its own, where its data folder is a small tmpfs; what is
on it is looked at through the process.  Skipped where the system does not let a user have one.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest

from station.recording import EventKind, events, frames, verify
from station.simulated import ArraySource, SimulatedCamera

ADDRESS = "127.10.2.1"
PATIENCE_S = 90.0
STATION = Path(sys.executable).with_name("station")
SIZE = "24m"
WIDTH, HEIGHT = 640, 400  # 256 kB a frame: some 70 fill the disk
SETTINGS = f"""
data_dir = "data"
port = 0
[storage]
keep_free_gb = 0.0
reserve_mb = 4.0
most_axles = {{axles}}
[[sensors]]
id = "left"
address = "{ADDRESS}"
packet_size = 8000
"""
UNSHARE = ["unshare", "--user", "--map-root-user", "--mount"]


def can_mount():
    """Whether a user may have a mount namespace with a tmpfs here."""
    if shutil.which("unshare") is None:
        return False
    command = [*UNSHARE, "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(command, check=False, capture_output=True).returncode == 0


pytestmark = pytest.mark.skipif(not can_mount(), reason="no mount namespaces for users here")


class Service:
    """`station serve` with its data on a small disk."""

    def __init__(self, folder, axles):
        (folder / "data").mkdir()
        config = folder / "station.toml"
        config.write_text(SETTINGS.format(axles=axles))
        mount = f"mount -t tmpfs -o size={SIZE} none data"
        script = f"{mount} && exec {STATION} serve --config {config} --json"
        clean = {k: v for k, v in os.environ.items() if not k.startswith("STATION_")}
        self._log = folder / "stderr"
        with self._log.open("w") as stderr:
            self.process = subprocess.Popen(
                [*UNSHARE, "sh", "-c", script],
                cwd=folder,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                env=clean | {"TMPDIR": str(folder)},
            )
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline()
            assert line, self._log.read_text()
            text += line
        self.data = Path(f"/proc/{self.process.pid}/root{folder}/data")
        key = (self.data / "first-admin-key").read_text().strip()
        self.call = httpx.Client(
            base_url=json.loads(text)["url"],
            headers={"Authorization": f"Bearer {key}"},
            timeout=PATIENCE_S,
            trust_env=False,
        )

    def close(self):
        self.call.close()
        self.process.send_signal(signal.SIGTERM)
        try:
            self.process.wait(30)
        finally:
            self.process.kill()
            self.process.wait()
            self.process.stdout.close()


@pytest.fixture
def camera():
    source = ArraySource([np.full((HEIGHT, WIDTH), value, np.uint8) for value in range(16)])
    with SimulatedCamera(ADDRESS, source, serial="S1") as camera:
        yield camera


@pytest.fixture
def service_with(tmp_path, camera):
    started = []

    def start(axles):
        started.append(Service(tmp_path, axles))
        return started[-1]

    yield start
    for service in started:
        service.close()


def test_disk_that_fills_up_in_the_middle_ends_the_recording_whole_and_the_service_lives_on(
    service_with, camera
):
    service = service_with(axles=10)
    call = service.call
    assert call.put("/v1/passes/p1", json={}).status_code == 201
    for _ in range(120):
        camera.trigger_line1()
        time.sleep(0.02)
    body = call.post("/v1/passes/p1/finish", json={"axles": 120}).json()
    (recording,) = body["recordings"]
    assert body["state"] == "recorded", body
    assert not recording["complete"]
    assert "disk full" in recording["summary"]
    assert recording["recorded"] + recording["lost"] == 120
    assert 40 < recording["recorded"] < 90

    path = service.data / "recordings" / "passes" / "p1" / "left.mcap"
    assert verify(path).ok
    kept = [frame.frame_id for frame in frames(path)]
    assert kept == list(range(1, recording["recorded"] + 1))
    assert EventKind.DISK_FULL in {event.kind for event in events(path)}
    # The store has its reserve, and the next pass is refused with numbers.
    refused = call.put("/v1/passes/p2", json={})
    assert refused.status_code == 507
    assert refused.headers["content-type"] == "application/problem+json"
    assert "10 frames" in refused.json()["detail"]
    assert call.get("/v1/passes/p2").status_code == 404

    path.unlink()
    assert call.put("/v1/passes/p2", json={}).status_code == 201
    for _ in range(3):
        camera.trigger_line1()
        time.sleep(0.02)
    (recording,) = call.post("/v1/passes/p2/finish", json={"axles": 3}).json()["recordings"]
    assert (recording["recorded"], recording["complete"]) == (3, True)
