"""Shows that the calls the handbook gives a controller are taken as they stand, by curl and in
Python; the worker that ends the job is a double."""

import os
import re
import subprocess
import threading
from pathlib import Path

import pytest
from served_station import ADMIN_KEY
from test_api_calibration import make_ready, record_session

from station.store import Job, JobState, Pass, PassState, end, report_progress, start, the

HANDBOOK = Path(__file__).resolve().parents[3] / "station" / "handbook"
PAGE = (HANDBOOK / "controller.md").read_text(encoding="utf-8")
PATIENCE_S = 30.0


def block(language):
    return re.search(rf"```{language}[^\n]*\n(.*?)```", PAGE, re.DOTALL)[1]


@pytest.fixture
def calibrated(served, call):
    record_session(call)
    order = {"sensor": "left", "session": "s1"}
    calibration = call.post("/v1/calibrations", json=order).raise_for_status().json()["id"]
    make_ready(served, calibration)
    place = "/v1/sensors/left/active-calibration"
    call.put(place, json={"calibration": calibration}, headers={"If-None-Match": "*"})


@pytest.fixture
def worker(served):
    """Ends the first job of measuring once somebody follows it, or the pass is asked for."""
    stop = threading.Event()

    def work():
        done = set()
        while not stop.wait(0.05):
            for kind, job_id in list(served.queue.submitted):
                if kind == "measure" and job_id not in done:
                    done.add(job_id)
                    _measure(served, job_id, stop)

    thread = threading.Thread(target=work)
    thread.start()
    yield
    stop.set()
    thread.join(PATIENCE_S)


def _measure(served, job_id, stop):
    with served.store.change() as session:
        start(the(session, Job, job_id), at=served.station.now())
    stop.wait(0.5)  # so that whoever follows has something to follow
    with served.store.change() as session:
        report_progress(session, job_id, 0.5, "frame 2 of 4")
    stop.wait(0.5)
    with served.store.change() as session:
        job = the(session, Job, job_id)
        the(session, Pass, job.subject).state = PassState.DONE
        end(job, JobState.DONE, at=served.station.now())


@pytest.mark.usefixtures("calibrated", "worker")
def test_the_calls_shown_with_curl_take_a_train_from_its_coming_to_its_wheels(served, call):
    shown = block("sh").replace("export STATION=http://127.0.0.1:8080 KEY=tl_...", "")
    assert "http://127.0.0.1:8080" not in shown
    here = {"STATION": served.url, "KEY": ADMIN_KEY, "NO_PROXY": "*"}
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", shown],
        env=os.environ | here,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    told = done.stdout
    assert '"ready":true' in told
    assert '"state":"recording"' in told
    assert "event: job" in told
    assert '"state":"done"' in told
    assert '"alarms":' in told
    assert "id,pass,measured_at" in told
    found = call.get("/v1/passes/2026-07-01-0705").json()
    assert (found["state"], found["train"], found["axles"]) == ("done", "IC 705", 4)
    assert [each["wheelset"] for each in found["consist"]] == ["ws-11", "ws-12", "ws-13", "ws-14"]


@pytest.mark.usefixtures("calibrated", "worker")
def test_the_program_shown_takes_a_train_from_its_coming_to_its_alarms(served):
    names = {"url": served.url, "key": ADMIN_KEY}
    exec(compile(block("python"), "controller.md", "exec"), names)  # noqa: S102  what is shown is run
    assert names["found"]["state"] == "done"
    assert names["alarms"] == []


def test_every_answer_that_the_page_explains_is_one_that_the_station_gives():
    from station.api.problems import STATUS_OF  # noqa: PLC0415  for this test alone

    explained = {
        int(status)
        for row in re.findall(r"^\| (.*?) \|", PAGE, re.MULTILINE)
        for status in re.findall(r"\b\d{3}\b", row)
    }
    given = set(STATUS_OF.values())
    assert explained <= given
    assert {401, 403, 404, 409, 422, 429, 503, 507} <= explained
