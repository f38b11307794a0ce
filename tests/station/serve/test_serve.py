"""Shows the whole service as it is started: its processes, a camera on the loopback network, a pass
through the death of each process.  The pictures show nothing: measuring is shown elsewhere."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest

from station.capture import CaptureClient
from station.recording import EventKind, events, frames, parts_of
from station.simulated import ArraySource, SimulatedCamera

ADDRESS = "127.23.0.2"
PATIENCE_S = 90.0
STATION = Path(sys.executable).with_name("station")


def settings_file(folder, port=0):
    path = folder / "station.toml"
    path.write_text(
        f'name = "yard"\ndata_dir = "data"\nport = {port}\n'
        f'[[sensors]]\nid = "left"\naddress = "{ADDRESS}"\n'
    )
    return path


def wait(reached, what):
    deadline = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < deadline, what() if callable(what) else what
        time.sleep(0.05)


class Service:
    """`station serve` as a process, and what it writes."""

    def __init__(self, folder, **environment):
        self.folder = folder
        self._log = folder / f"stderr-{time.monotonic_ns()}"
        clean = {k: v for k, v in os.environ.items() if not k.startswith("STATION_")}
        with self._log.open("w") as stderr:
            self.process = subprocess.Popen(
                [STATION, "serve", "--config", settings_file(folder), "--json"],
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                # A supervisor that is killed leaves its folder of sockets behind.
                env=clean | {"TMPDIR": str(folder)} | environment,
            )

    def wait_until_ready(self):
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline()
            assert line, self.lines
            text += line
        document = json.loads(text)
        assert document["ready"]
        self.url = document["url"]
        return self

    @property
    def lines(self):
        """Those that are whole: one may be on its way."""
        return self._log.read_text().rpartition("\n")[0].splitlines()

    @property
    def key(self):
        return (self.folder / "data/first-admin-key").read_text().strip()

    def pids(self, child):
        events = [json.loads(line) for line in self.lines if line.startswith("{")]
        return [e["pid"] for e in events if e["event"] == "started" and e["child"] == child]

    def wait_for_frames(self, count):
        """Wait until so many frames of the pass are in the file of the sensor."""
        (capture,) = self.folder.glob("treadline-*/left.sock")
        recorded = CaptureClient(capture).status
        wait(lambda: recorded().recorded == count, f"{count} frames in the file")

    def kill_and_wait(self, child):
        before = self.pids(child)
        os.kill(before[-1], signal.SIGKILL)
        wait(lambda: len(self.pids(child)) > len(before), f"{child} started again")

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(PATIENCE_S)

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.process.stdout.close()


def runs(pid):
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


@pytest.fixture(scope="module")
def camera():
    source = ArraySource([np.full((200, 320), 40, np.uint8)])
    with SimulatedCamera(ADDRESS, source, serial="S1") as camera:
        yield camera


@pytest.fixture(scope="module")
def service(camera, tmp_path_factory):
    service = Service(tmp_path_factory.mktemp("service")).wait_until_ready()
    yield service
    service.close()


@pytest.fixture(scope="module")
def call(service):
    headers = {"Authorization": f"Bearer {service.key}"}
    # A call that comes while the API process is started again waits in the socket's queue.
    with httpx.Client(
        base_url=service.url, headers=headers, timeout=PATIENCE_S, trust_env=False
    ) as client:
        yield client


def trigger(camera, times):
    for _ in range(times):
        camera.trigger_line1()
        time.sleep(0.05)


def finish(call, name, axles):
    return call.post(f"/v1/passes/{name}/finish", json={"axles": axles}).json()


def test_a_pass_is_recorded_frame_by_frame(camera, call):
    assert call.put("/v1/passes/plain", json={}).json()["state"] == "recording"
    trigger(camera, 5)
    body = finish(call, "plain", 5)
    (recording,) = body["recordings"]
    assert body["state"] == "recorded"
    assert (recording["recorded"], recording["lost"], recording["complete"]) == (5, 0, True)


def test_a_wheel_more_counted_than_recorded_is_a_lost_frame(camera, call):
    call.put("/v1/passes/short", json={})
    trigger(camera, 3)
    (recording,) = finish(call, "short", 4)["recordings"]
    assert (recording["recorded"], recording["lost"], recording["complete"]) == (3, 1, False)


def test_pictures_of_a_session_are_taken_on_command(call):
    place = "/v1/calibration-sessions/s1"
    call.put(place, json={"sensor": "left", "target": "dots:7x8:12"})
    assert [call.post(f"{place}/capture").json()["pictures"] for _ in range(3)] == [1, 2, 3]
    (recording,) = call.post(f"{place}/finish").json()["recordings"]
    assert (recording["recorded"], recording["complete"]) == (3, True)


def test_a_pass_outlives_the_api_process(service, camera, call):
    call.put("/v1/passes/api", json={})
    trigger(camera, 2)
    service.kill_and_wait("api")
    trigger(camera, 2)
    assert call.get("/v1/passes/api").json()["state"] == "recording"
    (recording,) = finish(call, "api", 4)["recordings"]
    assert (recording["recorded"], recording["complete"], recording["recovered"]) == (
        4,
        True,
        False,
    )


def test_what_a_killed_capture_process_had_recorded_is_kept(service, camera, call):
    call.put("/v1/passes/capture", json={})
    trigger(camera, 4)
    service.wait_for_frames(4)
    service.kill_and_wait("capture left")
    (recording,) = finish(call, "capture", 6)["recordings"]
    assert (recording["recorded"], recording["lost"], recording["recovered"]) == (4, 2, True)
    wait(lambda: call.get("/readyz").status_code == 200, "ready again")
    call.put("/v1/passes/after", json={})
    trigger(camera, 2)
    assert finish(call, "after", 2)["recordings"][0]["complete"]


def test_a_capture_process_killed_under_a_train_costs_the_wheels_of_that_time_alone(
    service, camera, call
):
    path = service.folder / "data/recordings/passes/rest/left.mcap"
    call.put("/v1/passes/rest", json={})
    trigger(camera, 3)
    service.wait_for_frames(3)
    service.kill_and_wait("capture left")
    wait(path.with_name("left.0002.mcap.active").exists, "the sensor to be armed again")
    wait(camera.trigger_line1, "the camera to wait for triggers")  # the first of three
    trigger(camera, 2)
    (recording,) = finish(call, "rest", 8)["recordings"]
    assert (recording["recorded"], recording["lost"], recording["recovered"]) == (6, 2, True)
    assert not recording["complete"]
    assert "gone on with after the capture process died" in recording["summary"]
    first, second = parts_of(path)
    numbers = [frame.frame_id for part in (first, second) for frame in frames(part)]
    assert numbers == [1, 2, 3, 4, 5, 6]
    (back,) = (each for each in events(second) if each.kind is EventKind.CAPTURE_BACK)
    assert "after frame 3" in back.detail


def test_a_job_outlives_the_worker_process(service, call):
    service.kill_and_wait("worker")
    order = {"sensor": "left", "session": "s1"}
    place = call.post("/v1/calibrations", json=order).headers["Location"]
    wait(lambda: call.get(place).json()["ended_at"] is not None, "the job's end")
    job = call.get(place).json()
    # The pictures show no target, and that is what it says.
    assert job["state"] == "failed"
    assert "picture" in job["error"]


def test_a_second_station_on_the_same_data_is_refused(service):
    second = Service(service.folder)
    try:
        assert second.process.wait(PATIENCE_S) == 2
        (line,) = second.lines
        assert "a station runs already" in line
    finally:
        second.close()


def test_the_station_ends_in_order_and_its_key_is_shown_once(service, camera, call):
    call.put("/v1/passes/open", json={})
    trigger(camera, 2)
    service.wait_for_frames(2)
    pids = [service.pids(child)[-1] for child in ("api", "capture left", "worker")]
    assert service.stop() == 0
    assert not any(runs(pid) for pid in pids)
    assert (service.folder / "data/recordings/passes/open/left.mcap").exists()

    again = Service(service.folder).wait_until_ready()
    try:
        assert not any("admin key" in line for line in again.lines)
        headers = {"Authorization": f"Bearer {service.key}"}
        with httpx.Client(base_url=again.url, headers=headers, trust_env=False) as client:
            body = client.get("/v1/passes/open").json()
        # It had no calibration: recorded is as far as it can go.
        assert (body["state"], body["recordings"][0]["recorded"]) == ("recorded", 2)

        pids = [again.pids(child)[-1] for child in ("api", "capture left", "worker")]
        again.process.kill()
        names = ("api", "capture left", "worker")
        last = dict(zip(names, pids, strict=True))
        wait(
            lambda: not any(runs(pid) for pid in pids),
            lambda: f"{[name for name, pid in last.items() if runs(pid)]} outlived the supervisor",
        )
    finally:
        again.close()


def test_a_key_that_could_be_guessed_is_one_line_and_exit_2(tmp_path):
    service = Service(tmp_path, STATION_ADMIN_KEY="letmein")
    try:
        assert service.process.wait(PATIENCE_S) == 2
        assert service.lines == [
            "station: STATION_ADMIN_KEY has 7 characters; give a random one of 32 or more"
        ]
    finally:
        service.close()


def test_a_port_in_use_is_one_line_and_exit_2(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        reply = subprocess.run(
            [STATION, "serve", "--config", settings_file(tmp_path, port)],
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    assert reply.returncode == 2
    assert reply.stderr == (
        f"station: port {port} of 127.0.0.1 is in use; stop what listens there, "
        "or set another port\n"
    )
