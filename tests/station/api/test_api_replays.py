"""Shows which replays are taken and which refused, and what the API tells of them.  What a replay
measures is shown with the worker."""

from datetime import UTC, datetime

import pytest
from served_station import Served

from station.store import (
    Calibration,
    CalibrationState,
    JobKind,
    Pass,
    PassState,
    Recording,
    Replay,
    RigCalibration,
    the,
)

PLACE = "/v1/replays"
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
RIG_DOCUMENT = '{"sensors": [{"sensor": "left"}, {"sensor": "right"}]}'


def a_calibration(name, sensor, state=CalibrationState.READY):
    return Calibration(
        id=name,
        state=state,
        sensor=sensor,
        target="dots:7x8:12",
        method="joint",
        recording_ids={"recordings": [], "laser_off": []},
        created_at=NOON,
        job_id="j",
        document="{}",
    )


def a_recording(name, sensor="left", **more):
    return Recording(
        id=name,
        sensor=sensor,
        path=f"{name}.mcap",
        opened_at=NOON,
        recovered=False,
        **({"closed_at": NOON, "recorded": 4} | more),
    )


@pytest.fixture
def recorded(served):
    """A pass of two sensors, an upload, and what cannot be replayed."""
    fill(served)


@pytest.fixture(scope="module")
def untouched(tmp_path_factory, empty_store):
    """The same, of which the calls of several tests change nothing."""
    served = Served(tmp_path_factory.mktemp("untouched"), empty_store)
    fill(served)
    yield served
    served.close()


def fill(served):
    with served.store.change() as session:
        session.add(Pass(id="p1", state=PassState.DONE, opened_at=NOON))
        session.add(Pass(id="p2", state=PassState.FAILED, opened_at=NOON))
        session.add_all(
            [a_calibration("cl", "left"), a_calibration("cr", "right")]
            + [a_calibration("solving", "left", CalibrationState.SOLVING)]
        )
        ordered = {"calibrations": {"left": "cl", "right": "cr"}, "recordings": {}}
        session.add(
            RigCalibration(
                id="g1",
                state=CalibrationState.READY,
                rig="wheel",
                ordered=ordered,
                created_at=NOON,
                document=RIG_DOCUMENT,
            )
        )
        session.flush()
        of_pass = {"pass_id": "p1"}
        session.add_all([
            a_recording("p1.left", calibration_id="cl", **of_pass),
            a_recording("p1.right", "right", calibration_id="cr", **of_pass),
            a_recording("p2.left", calibration_id="cl", pass_id="p2"),
            a_recording("upload.1", sha256="0"),
            a_recording("upload.2", sha256="1"),
            a_recording("upload.3", "right", sha256="2"),
            a_recording("empty", recorded=0),
            a_recording("runs", closed_at=None),
            a_recording("gone", deleted_at=NOON, deleted_why="quota"),
        ])


@pytest.mark.usefixtures("recorded")
def test_an_order_is_a_job_that_the_worker_is_told_of(served, call):
    body = {"pass": "p1", "calibrations": {"left": "cl", "right": "cr"}}
    reply = call.post(PLACE, json=body)
    assert reply.status_code == 202
    answer = reply.json()
    assert reply.headers["Location"] == f"/v1/jobs/{answer['job']}"
    assert int(reply.headers["Retry-After"]) > 0
    assert served.queue.submitted == [("replay", answer["job"])]
    assert (answer["state"], answer["measurements"], answer["reference"]) == ("queued", 0, "S1002")
    assert [each["recordings"] for each in answer["steps"]] == [["p1.left"], ["p1.right"]]
    assert call.get(f"{PLACE}/{answer['id']}").json() == answer
    assert call.get(PLACE).json() == {"replays": [answer], "next": None}
    assert call.get(PLACE, params={"pass": "p2"}).json()["replays"] == []
    job = call.get(reply.headers["Location"]).json()
    assert (job["kind"], job["subject"]) == (JobKind.REPLAY, answer["id"])


@pytest.mark.usefixtures("recorded")
def test_the_same_order_with_an_idempotency_key_is_one_replay(served, call):
    body = {"recordings": ["upload.1"], "calibrations": {"left": "cl"}}
    key = {"Idempotency-Key": "k1"}
    first, again = (call.post(PLACE, json=body, headers=key) for _ in range(2))
    assert first.json() == again.json()
    assert len(call.get(PLACE).json()["replays"]) == 1


@pytest.mark.usefixtures("recorded")
def test_what_a_replay_came_to_is_told_step_by_step(served, call):
    body = {"recordings": ["p1.left", "upload.1"], "calibrations": {"left": "cl"}}
    answer = call.post(PLACE, json=body).json()
    with served.store.change() as session:
        row = the(session, Replay, answer["id"])
        row.results = {"p1.left": {"wheels": 4, "added": 0}, "upload.1": {"refused": "dark"}}
    told = call.get(f"{PLACE}/{answer['id']}").json()
    assert told["steps"] == [
        {"recordings": ["p1.left"], "wheels": 4, "added": 0, "refused": None},
        {"recordings": ["upload.1"], "wheels": None, "added": None, "refused": "dark"},
    ]
    assert told["added"] == 0


@pytest.mark.usefixtures("recorded")
def test_a_replay_is_cancelled_as_any_job(call):
    body = {"recordings": ["upload.1"], "calibrations": {"left": "cl"}}
    answer = call.post(PLACE, json=body).json()
    assert call.delete(f"/v1/jobs/{answer['job']}").json()["state"] == "cancelled"
    assert call.get(f"{PLACE}/{answer['id']}").json()["state"] == "cancelled"


@pytest.mark.parametrize("of", [{"pass": "p1"}, {"recordings": ["upload.1", "upload.3"]}])
@pytest.mark.usefixtures("recorded")
def test_on_a_rig_its_sensors_are_one_step_with_the_calibrations_they_have(call, of):
    answer = call.post(PLACE, json=of | {"rig_calibration": "g1"}).json()
    assert answer["calibrations"] == {"left": "cl", "right": "cr"}
    assert len(answer["steps"]) == 1


LEFT = {"calibrations": {"left": "cl"}}


@pytest.mark.parametrize(
    ("body", "status", "says"),
    [
        (LEFT, 422, "either recordings or a pass"),
        (LEFT | {"pass": "p1", "recordings": ["upload.1"]}, 422, "either recordings or a pass"),
        (LEFT | {"recordings": ["upload.1", "upload.1"]}, 422, "given twice"),
        (LEFT | {"recordings": ["nowhere"]}, 404, "recording 'nowhere'"),
        (LEFT | {"recordings": ["../../etc/passwd"]}, 422, "recordings"),
        (LEFT | {"pass": "p9"}, 404, "pass 'p9'"),
        (LEFT | {"recordings": ["runs"]}, 409, "still runs"),
        (LEFT | {"recordings": ["gone"]}, 409, "recording gone was deleted on 2026-07-01 (quota)"),
        (LEFT | {"recordings": ["empty"]}, 422, "none of the recordings holds a frame"),
        (LEFT | {"recordings": ["upload.3"]}, 422, "of which no recording is given"),
        ({"recordings": ["upload.1"]}, 422, "no calibration for sensor left"),
        (LEFT | {"pass": "p1"}, 422, "no calibration for sensor right"),
        (
            {"recordings": ["upload.1"], "calibrations": {"left": "cr"}},
            422,
            "is of sensor right, not of left",
        ),
        (
            {"recordings": ["upload.1"], "calibrations": {"left": "solving"}},
            409,
            "solving is solving",
        ),
        ({"recordings": ["upload.1"], "calibrations": {"left": "c9"}}, 404, "calibration 'c9'"),
        (
            {"recordings": ["upload.1", "upload.2"], "rig_calibration": "g1"},
            422,
            "two recordings of one sensor",
        ),
        (LEFT | {"recordings": ["p2.left"], "reference": "LMA"}, 409, "pass p2 is failed"),
        (LEFT | {"recordings": ["upload.1"], "reference": "/etc/passwd"}, 422, "reference"),
        (LEFT | {"recordings": ["upload.1"], "unknown": 1}, 422, "unknown"),
    ],
)
def test_what_cannot_be_measured_once_more_is_refused_and_leaves_no_job(
    untouched, body, status, says
):
    with untouched.client() as call:
        reply = call.post(PLACE, json=body)
        assert reply.status_code == status, reply.text
        assert says in reply.json()["detail"]
        assert untouched.queue.submitted == []
        assert call.get(PLACE).json()["replays"] == []
        assert call.get("/v1/jobs").json()["jobs"] == []
