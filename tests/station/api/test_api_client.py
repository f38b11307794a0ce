"""Shows the client's calls on the real API: a pass from arming to its wheels, lists, an upload, a
replay, a job that is cancelled."""

import threading
from datetime import timedelta

import pytest
from served_station import ADMIN_KEY
from test_api_calibration import make_ready
from test_api_uploads import a_recording

from station.client import CallRefused, StationClient
from station.store import Job, JobState, Pass, PassState, end, start, the


@pytest.fixture
def client(served):
    with StationClient.connect(served.url, ADMIN_KEY, timeout_s=10.0) as client:
        yield client


@pytest.fixture
def calibrated(served, client, tmp_path_factory):
    """A station with a calibration in force, solved from an upload."""
    file = tmp_path_factory.mktemp("elsewhere") / "poses.mcap"
    file.write_bytes(a_recording(file.parent))
    upload = client.upload(file)
    body = {"sensor": "left", "recordings": [upload["id"]], "target": "dots:7x8:12"}
    with served.client() as call:
        calibration = call.post("/v1/calibrations", json=body).raise_for_status().json()["id"]
    make_ready(served, calibration)
    client.activate(sensor="left", calibration=calibration)
    return calibration, upload["id"]


def finish_job(served, job_id, *, pass_id=None):
    with served.store.change() as session:
        job = the(session, Job, job_id)
        start(job, at=served.station.now())
        end(job, JobState.DONE, at=served.station.now())
        if pass_id is not None:
            the(session, Pass, pass_id).state = PassState.DONE


def test_a_pass_is_armed_finished_and_waited_for(served, client, calibrated):
    armed = client.arm_pass("p1", train="7:05")
    assert armed["state"] == "recording"
    assert client.arm_pass("p1", train="7:05")["opened_at"] == armed["opened_at"]
    closed = client.finish_pass("p1", axles=4, consist=["ws-1", {"wheelset": "ws-2"}])
    assert (closed["state"], closed["axles"]) == ("measuring", 4)
    assert [each["wheelset"] for each in closed["consist"]] == ["ws-1", "ws-2"]
    finish_job(served, closed["job"], pass_id="p1")
    assert client.await_pass("p1", timeout_s=10.0)["state"] == "done"
    assert client.one_pass("p1")["state"] == "done"
    assert client.wheels("p1") == []
    assert client.train("p1")["pass_id"] == "p1"
    assert client.station()["pass_in_progress"] is None


def test_a_pass_that_nobody_will_measure_is_not_waited_for(client):
    client.arm_pass("p1")
    client.finish_pass("p1", axles=4)
    found = client.await_pass("p1", timeout_s=10.0)
    assert found["state"] == "recorded"
    assert "no sensor had an active calibration" in found["reason"]


def test_lists_come_whole_and_filtered(client):
    for number in range(3):
        client.arm_pass(f"p{number}", train=f"t{number % 2}")
        client.finish_pass(f"p{number}", axles=4)
    assert [each["id"] for each in client.passes()] == ["p2", "p1", "p0"]
    assert [each["id"] for each in client.passes(train="t0")] == ["p2", "p0"]
    assert list(client.passes(state="armed")) == []
    assert [each["id"] for each in client.recordings(pass_id="p1")] == [
        "pass.p1.right",
        "pass.p1.left",
    ]
    assert list(client.jobs()) == []
    assert list(client.measurements()) == []


def test_since_and_until_are_of_this_hosts_clock_where_no_zone_is_given(served, client):
    client.arm_pass("p1")
    now = served.station.now()
    assert list(client.passes(since=now + timedelta(hours=1))) == []
    local = (now - timedelta(hours=1)).astimezone().replace(tzinfo=None)
    assert [each["id"] for each in client.passes(since=local)] == ["p1"]


def test_an_upload_is_replayed_and_the_replay_told_in_the_end(served, client, calibrated):
    calibration, upload = calibrated
    ended = threading.Thread(target=_end_first_replay, args=(served,))
    ended.start()
    told = client.replay(recordings=[upload], calibrations={"left": calibration}, timeout_s=30.0)
    ended.join()
    assert told["state"] == "done"
    assert told["steps"][0]["recordings"] == [upload]
    assert client.picture(upload, 1, max_width=16).startswith(b"\x89PNG")


def _end_first_replay(served):
    told = threading.Event()
    while not (orders := [name for kind, name in served.queue.submitted if kind == "replay"]):
        told.wait(0.01)
    finish_job(served, orders[0])


def test_a_job_is_followed_and_cancelled(client, calibrated):
    client.arm_pass("p1")
    job = client.finish_pass("p1", axles=4)["job"]
    told = client.job_events(job)
    assert next(told)["state"] == "queued"
    client.cancel_job(job)
    assert [each["state"] for each in told] == ["cancelled"]
    assert client.job(job)["state"] == "cancelled"
    assert [each["id"] for each in client.jobs(subject="p1")] == [job]


def test_a_refusal_tells_what_happened_for_people_and_programs(client):
    client.arm_pass("p1")
    with pytest.raises(CallRefused, match="pass p1 is recording") as refused:
        client.arm_pass("p2")
    assert refused.value.status == 409
    assert refused.value.problem["type"] == "urn:treadline:problem:StateConflict"
    assert refused.value.problem["state"] == "recording"
