"""Shows sessions, orders, files and activations of rigs over HTTP.  The solving is the worker's
and shown there."""

import json

import pytest
from rig_recordings import true_rig

from station.store import Calibration, CalibrationState, Recording, RigCalibration, the

SENSORS = (
    {"id": "inner", "address": "127.0.0.2"},
    {"id": "outer", "address": "127.0.0.3"},
    {"id": "lone", "address": "127.0.0.4", "side": "right"},
)
WITH_RIG = {"sensors": SENSORS, "rigs": [{"id": "wheel", "sensors": ["inner", "outer"]}]}
SESSION = "/v1/calibration-sessions/s1"
BODY = {"rig": "wheel", "target": "dots:7x8:12", "targets": {"outer": "dots:6x9:12"}}
ACTIVE = "/v1/rigs/wheel/active-calibration"

pytestmark = pytest.mark.parametrize("served", [WITH_RIG], indirect=True)


@pytest.fixture
def rig_file():
    return json.loads(true_rig().model_dump_json())


def calibrate_sensors(served, call):
    """Have a calibration in force on each sensor of the rig."""
    for sensor in ("inner", "outer"):
        with served.store.change() as session:
            session.add(
                Calibration(
                    id=f"of-{sensor}",
                    state=CalibrationState.READY,
                    sensor=sensor,
                    target="dots:7x8:12",
                    method="joint",
                    recording_ids={"recordings": [], "laser_off": []},
                    created_at=served.station.now(),
                    job_id="j",
                    document="{}",
                )
            )
        body = {"calibration": f"of-{sensor}"}
        assert call.put(f"/v1/sensors/{sensor}/active-calibration", json=body).status_code == 200


def record_session(call, pictures=3):
    assert call.put(SESSION, json=BODY).status_code == 201
    for _ in range(pictures):
        call.post(f"{SESSION}/capture")
    return call.post(f"{SESSION}/finish").json()


def test_a_session_of_a_rig_takes_a_picture_with_each_of_its_sensors(served, call):
    body = record_session(call)
    assert (body["state"], body["sensor"], body["rig"]) == ("recorded", None, "wheel")
    assert (body["pictures"], body["targets"]) == (3, {"outer": "dots:6x9:12"})
    assert [(r["sensor"], r["expected"], r["recorded"]) for r in body["recordings"]] == [
        ("inner", 3, 3),
        ("outer", 3, 3),
    ]
    assert served.captures["lone"].plans == []
    assert call.put(SESSION, json=BODY).json() == body
    other = call.put(SESSION, json=BODY | {"targets": {}})
    assert (other.status_code, "is of rig wheel" in other.json()["detail"]) == (409, True)


def test_a_session_of_a_rig_holds_its_sensors_and_no_other(served, call):
    assert call.put(SESSION, json=BODY).status_code == 201
    one = {"sensor": "inner", "target": "dots:7x8:12"}
    refused = call.put("/v1/calibration-sessions/s2", json=one)
    assert refused.status_code == 409
    assert "calibration session s1 on sensor inner is open" in refused.json()["detail"]
    free = call.put("/v1/calibration-sessions/s3", json=one | {"sensor": "lone"})
    assert free.status_code == 201


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"sensor": "inner"}, "give either a sensor or a rig"),
        ({"rig": None}, "give either a sensor or a rig"),
        ({"rig": "other"}, "rig 'other': the station has wheel"),
        ({"targets": {"lone": "dots:7x8:12"}}, "a target of sensor lone; allowed: inner, outer"),
    ],
)
def test_a_session_that_fits_no_rig_is_refused(served, call, change, says):
    reply = call.put(SESSION, json=BODY | change)
    assert (reply.status_code, says in reply.json()["detail"]) == (422, True)


def test_a_rig_is_ordered_from_its_session_and_rests_on_the_calibrations_in_force(served, call):
    calibrate_sensors(served, call)
    record_session(call)
    order = {"rig": "wheel", "session": "s1", "board_sigma_mm": 0.01}
    reply = call.post("/v1/rig-calibrations", json=order)
    assert reply.status_code == 202
    body = reply.json()
    assert reply.headers["Location"] == f"/v1/jobs/{body['job']}"
    assert served.queue.submitted == [("calibrate_rig", body["job"])]
    assert (body["state"], body["rig"]) == ("solving", "wheel")
    assert body["ordered"] == {
        "recordings": {"inner": ["session.s1.inner"], "outer": ["session.s1.outer"]},
        "calibrations": {"inner": "of-inner", "outer": "of-outer"},
        "targets": {"inner": "dots:7x8:12", "outer": "dots:6x9:12"},
        "same_board": False,
        "board_sigma_mm": 0.01,
    }
    assert call.get(f"/v1/rig-calibrations/{body['id']}").json() == body
    early = call.put(ACTIVE, json={"calibration": body["id"]})
    assert (early.status_code, early.json()["state"]) == (409, "solving")


def test_a_sensor_of_a_rig_is_calibrated_from_its_part_of_the_session(served, call):
    record_session(call)
    body = call.post("/v1/calibrations", json={"sensor": "outer", "session": "s1"}).json()
    assert (body["recordings"], body["target"]) == (["session.s1.outer"], "dots:6x9:12")
    refused = call.post("/v1/calibrations", json={"sensor": "lone", "session": "s1"})
    assert "session s1 of rig wheel has no sensor lone" in refused.json()["detail"]


@pytest.mark.parametrize(
    ("order", "status", "says"),
    [
        ({"rig": "wheel"}, 422, "give either a session or recordings"),
        ({"rig": "other", "session": "s1"}, 422, "the station has wheel"),
        ({"rig": "wheel", "session": "s9"}, 404, "calibration session 's9'"),
        ({"rig": "wheel", "recordings": {"inner": "r"}}, 422, "allowed: one of each sensor"),
        ({"rig": "wheel", "session": "s1", "board_sigma_mm": 0}, 422, "board_sigma_mm"),
    ],
)
def test_an_order_that_makes_no_rig_is_refused(served, call, order, status, says):
    reply = call.post("/v1/rig-calibrations", json=order)
    assert (reply.status_code, says in reply.json()["detail"]) == (status, True)


def test_a_rig_whose_sensors_are_not_calibrated_cannot_be_ordered(served, call):
    record_session(call)
    reply = call.post("/v1/rig-calibrations", json={"rig": "wheel", "session": "s1"})
    assert reply.status_code == 409
    assert "sensor inner has no active calibration" in reply.json()["detail"]


def test_a_file_is_taken_in_and_comes_into_force_version_by_version(served, call, rig_file):
    reply = call.post("/v1/rig-calibrations/files", json=rig_file)
    assert reply.status_code == 201
    calibration = reply.json()["id"]
    assert reply.headers["Location"] == f"/v1/rig-calibrations/{calibration}"
    assert call.get(ACTIVE).status_code == 404
    body = {"calibration": calibration}
    first = call.put(ACTIVE, json=body)
    assert (first.status_code, first.headers["ETag"]) == (200, '"1"')
    assert call.put(ACTIVE, json=body).status_code == 428
    assert call.put(ACTIVE, json=body, headers={"If-Match": '"7"'}).status_code == 412
    assert call.put(ACTIVE, json=body, headers={"If-Match": '"1"'}).json()["version"] == 2
    assert call.get(ACTIVE).headers["ETag"] == '"2"'
    (rig,) = call.get("/v1/station").json()["rigs"]
    assert rig == {
        "id": "wheel",
        "side": "left",
        "sensors": ["inner", "outer"],
        "anchor": "inner",
        "active_calibration": calibration,
    }


def test_a_file_that_is_not_of_the_stations_rig_is_refused(served, call, rig_file):
    strange = rig_file | {"rig": "other"}
    assert call.post("/v1/rig-calibrations/files", json=strange).status_code == 422
    rig_file["sensors"][1]["sensor"] = "lone"
    reply = call.post("/v1/rig-calibrations/files", json=rig_file)
    assert "has sensors inner, lone; the station's has inner, outer" in reply.json()["detail"]
    rig_file["covariance"] = [[0.0]]
    reply = call.post("/v1/rig-calibrations/files", json=rig_file)
    assert (reply.status_code, "allowed: 38 x 38" in reply.json()["detail"]) == (422, True)


def test_a_rig_that_stands_nowhere_does_not_come_into_force(served, call, rig_file):
    calibration = call.post("/v1/rig-calibrations/files", json=rig_file | {"survey": None}).json()
    reply = call.put(ACTIVE, json={"calibration": calibration["id"]})
    assert (reply.status_code, "cannot measure wheels" in reply.json()["detail"]) == (422, True)


def test_a_pass_is_recorded_under_the_rig_in_force_and_carries_its_file(served, call, rig_file):
    calibration = call.post("/v1/rig-calibrations/files", json=rig_file).json()["id"]
    call.put(ACTIVE, json={"calibration": calibration})
    body = call.put("/v1/passes/p1", json={}).json()
    told = {each["sensor"]: each["rig_calibration"] for each in body["recordings"]}
    assert told == {"inner": calibration, "outer": calibration, "lone": None}
    assert set(served.captures["inner"].plans[0].attachments) == {"rig.json"}
    assert served.captures["lone"].plans[0].attachments == {}
    with served.store.look() as session:
        assert the(session, Recording, "pass.p1.inner").rig_calibration_id == calibration
        assert the(session, RigCalibration, calibration).job_id is None
