"""Shows the log of a station from its start to its end: each line JSON, of every process, joined by
the same names, and without a secret.  The pictures show nothing: the job fails, and says so."""

import json
import os
import signal
import ssl
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest
from postgres_server import initdb

from station.simulated import ArraySource, SimulatedCamera

ADDRESS = "127.36.0.2"
PATIENCE_S = 90.0
PASSWORD = "of-the-database-4711"
FOREIGN_KEY = "tl_0123abcd_" + "NobodyKnowsThisOne" * 2 + "4711471"
STATION = Path(sys.executable).with_name("station")
SETTINGS = f"""
name = "yard"
data_dir = "data"
port = 0
log_level = "debug"
[tls]
certificate = "station.pem"
key = "station.key"
[[sensors]]
id = "left"
address = "{ADDRESS}"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("life")
    (folder / "station.toml").write_text(SETTINGS)
    subprocess.run(
        ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"]
        + ["-nodes", "-days", "2", "-subj", "/CN=station", "-addext", "subjectAltName=IP:127.0.0.1"]
        + ["-keyout", folder / "station.key", "-out", folder / "station.pem"],
        check=True,
        capture_output=True,
    )
    return folder


@pytest.fixture(scope="module")
def environment(request, folder):
    """With a database that has a password, where this host has one to start."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("STATION_")}
    if initdb() is not None:
        url = request.getfixturevalue("postgres").empty_database()
        clean["STATION_STORE_URL"] = url.replace("treadline@", f"treadline:{PASSWORD}@")
    return clean | {"TMPDIR": str(folder)}


@pytest.fixture(scope="module")
def life(folder, environment):
    """Let a station live through a pass, a job, refusals and the death of a process.

    Return the text of its log, the secrets that were used, and the job.
    """
    source = ArraySource([np.full((200, 320), 40, np.uint8)])
    log = folder / "stderr"
    with SimulatedCamera(ADDRESS, source, serial="S1") as camera, log.open("w") as stderr:
        process = subprocess.Popen(
            [STATION, "serve", "--config", folder / "station.toml", "--json"],
            stdout=subprocess.PIPE, stderr=stderr, text=True, env=environment,
        )  # fmt: skip
        try:
            url = announced(process, log)
            key = (folder / "data/first-admin-key").read_text().strip()
            trusting = ssl.create_default_context(cafile=folder / "station.pem")
            with httpx.Client(
                base_url=url, verify=trusting, timeout=PATIENCE_S, trust_env=False
            ) as client:
                refused = {"Authorization": f"Bearer {FOREIGN_KEY}"}
                client.get(f"/v1/passes/{FOREIGN_KEY}", headers=refused)
                client.headers["Authorization"] = f"Bearer {key}"
                record_a_pass(client, camera)
                job = fail_a_calibration(client)
                kill_the_capture(client, log)
        finally:
            process.send_signal(signal.SIGTERM)
            process.wait(PATIENCE_S)
            process.stdout.close()
    in_file = (folder / "station.key").read_text().splitlines()
    return log.read_text(), [key, FOREIGN_KEY, PASSWORD, *in_file[1:-1]], job


def announced(process, log):
    text = ""
    while not text.endswith("}\n"):
        line = process.stdout.readline()
        assert line, log.read_text()
        text += line
    return json.loads(text)["url"]


def record_a_pass(client, camera):
    client.put("/v1/passes/p1", json={}, headers={"X-Request-Id": "the-train-comes"})
    camera.trigger_line1()
    time.sleep(0.05)
    client.post("/v1/passes/p1/finish", json={"axles": 1})


def fail_a_calibration(client):
    place = "/v1/calibration-sessions/s1"
    client.put(place, json={"sensor": "left", "target": "dots:7x8:12"})
    client.post(f"{place}/capture")
    client.post(f"{place}/finish")
    order = {"sensor": "left", "session": "s1"}
    answer = client.post("/v1/calibrations", json=order, headers={"X-Request-Id": "solve-it"})
    job = answer.headers["Location"]
    wait(lambda: client.get(job).json()["ended_at"] is not None)
    return job.rpartition("/")[2]


def kill_the_capture(client, log):
    whole = log.read_text().rpartition("\n")[0].splitlines()  # a line may be on its way
    events = [json.loads(line) for line in whole if line.startswith("{")]
    (pid,) = [e["pid"] for e in events if e["event"] == "started" and e["child"] == "capture left"]
    os.kill(pid, signal.SIGKILL)
    restarts = 'station_process_restarts_total{process="capture left"} 1.0'
    wait(lambda: restarts in client.get("/metrics").text)


def wait(reached):
    deadline = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.fixture
def lines(life):
    text, _, _ = life
    # What a person is told of the first key is no line of the log.
    return [json.loads(line) for line in text.splitlines() if not line.startswith("admin key:")]


def test_every_line_is_json_with_its_moment_its_level_and_its_process(lines):
    assert {"api", "capture left", "supervisor", "worker"} <= {line["process"] for line in lines}
    for line in lines:
        assert {"event", "level", "timestamp", "process"} <= line.keys()


def test_no_secret_is_in_the_log(life):
    text, secrets, _ = life
    for secret in secrets:
        assert secret not in text
        assert secret[-12:] not in text
    assert "tl_0123abcd_***" in text  # the call was told, and its key struck out


def test_a_pass_is_followed_through_the_processes_by_its_name(lines):
    of_pass = {(line["process"], line["event"]) for line in lines if line.get("pass") == "p1"}
    assert {
        ("api", "answered"),
        ("api", "recording closed"),
        ("capture left", "recording began"),
        ("capture left", "recording finished"),
    } <= of_pass
    (armed,) = [line for line in lines if line.get("request") == "the-train-comes"]
    assert (armed["who"], armed["status"], armed["pass"]) == ("first admin", 201, "p1")
    (began,) = [
        line for line in lines if line["event"] == "recording began" and line.get("pass") == "p1"
    ]
    assert (began["sensor"], began["recording"]) == ("left", "pass.p1.left")


def test_a_job_is_followed_from_the_call_that_ordered_it_to_its_end(life, lines):
    _, _, job = life
    (ordered,) = [line for line in lines if line["event"] == "job ordered" and line["job"] == job]
    assert ordered["request"] == "solve-it"
    of_job = [line for line in lines if line["process"] == "worker" and line.get("job") == job]
    assert [line["event"] for line in of_job] == ["job taken up", "job ended"]
    assert {line["kind"] for line in of_job} == {"calibrate"}
    assert of_job[-1]["state"] == "failed"
    assert "picture" in of_job[-1]["error"]


def test_the_death_of_a_process_is_told_by_its_supervisor(lines):
    (ended,) = [line for line in lines if line["event"] == "ended"]
    assert (ended["child"], ended["exitcode"], ended["level"]) == ("capture left", -9, "error")
