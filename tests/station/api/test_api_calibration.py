"""Shows sessions, orders of calibrations and their coming into force, over HTTP.  The solving is
the worker's and shown there."""

from station.operations import Sessions
from station.store import (
    Calibration,
    CalibrationPoints,
    CalibrationState,
    Job,
    JobState,
    end,
    start,
    the,
)

SESSION = "/v1/calibration-sessions/s1"
BODY = {"sensor": "left", "target": "dots:7x8:12"}


def record_session(call, pictures=3):
    assert call.put(SESSION, json=BODY).status_code == 201
    for _ in range(pictures):
        call.post(f"{SESSION}/capture")
    return call.post(f"{SESSION}/finish").json()


def make_ready(served, calibration_id):
    """Do what the worker does when it has solved a calibration."""
    with served.store.change() as session:
        row = the(session, Calibration, calibration_id)
        row.state, row.document, row.passed = CalibrationState.READY, '{"sensor": "left"}', True
        session.add(CalibrationPoints(calibration_id=calibration_id, csv="image,kind\n"))
        job = the(session, Job, row.job_id)
        start(job, at=served.station.now())
        end(job, JobState.DONE, at=served.station.now())


def a_ready_calibration(served, call):
    if call.get(SESSION).status_code == 404:
        record_session(call)
    order = {"sensor": "left", "session": "s1"}
    calibration = call.post("/v1/calibrations", json=order).json()["id"]
    make_ready(served, calibration)
    return calibration


def test_a_session_counts_its_pictures_and_closes_with_all_of_them(served, call):
    assert call.put(SESSION, json=BODY).json()["state"] == "open"
    assert served.captures["left"].plans[0].trigger == "software"
    assert served.captures["right"].plans == []
    counts = [call.post(f"{SESSION}/capture").json()["pictures"] for _ in range(3)]
    assert counts == [1, 2, 3]
    body = call.post(f"{SESSION}/finish").json()
    assert body["state"] == "recorded"
    assert [(r["expected"], r["recorded"]) for r in body["recordings"]] == [(3, 3)]
    assert call.post(f"{SESSION}/finish").json() == body
    assert call.put(SESSION, json=BODY).json() == body
    assert call.get(SESSION).json() == body


def test_pictures_are_taken_only_while_the_session_is_open(call):
    record_session(call)
    reply = call.post(f"{SESSION}/capture")
    assert (reply.status_code, reply.json()["state"]) == (409, "recorded")


def test_a_picture_that_does_not_arrive_is_not_counted(served, call):
    call.put(SESSION, json=BODY)
    served.captures["left"].broken = "127.0.0.2: no camera answers"
    assert call.post(f"{SESSION}/capture").status_code == 503
    served.captures["left"].broken = None
    assert call.get(SESSION).json()["pictures"] == 0


def test_a_session_holds_its_sensor_against_passes_and_other_sessions(call):
    call.put(SESSION, json=BODY)
    for path, body in (("/v1/passes/p1", {}), ("/v1/calibration-sessions/s2", BODY)):
        reply = call.put(path, json=body)
        assert (reply.status_code, reply.json()["state"]) == (409, "open")
    other = {**BODY, "sensor": "right"}
    assert call.put("/v1/calibration-sessions/s3", json=other).status_code == 201


def test_a_session_that_lost_its_capture_is_closed_by_the_next_api_process(served, call):
    call.put(SESSION, json=BODY)
    call.post(f"{SESSION}/capture")
    Sessions(served.station).take_up()
    assert call.get(SESSION).json()["state"] == "open"
    served.captures["left"].plan = None
    served.saved["left"] = 1
    Sessions(served.station).take_up()
    body = call.get(SESSION).json()
    assert (body["state"], body["recordings"][0]["recovered"]) == ("recorded", True)


def test_unusable_sessions_are_refused_with_what_is_allowed(call):
    reply = call.put(SESSION, json={**BODY, "sensor": "middle"})
    assert reply.status_code == 422
    assert "left, right" in reply.json()["detail"]
    reply = call.put(SESSION, json={**BODY, "target": "dots:7x8"})
    assert reply.status_code == 422
    assert "dots:ROWSxCOLS:PITCH_MM" in reply.json()["detail"]
    assert call.put(SESSION, json=BODY).status_code == 201
    reply = call.put(SESSION, json={**BODY, "target": "dots:7x8:6"})
    assert (reply.status_code, reply.json()["state"]) == (409, "open")


def test_an_order_is_answered_202_with_the_place_of_its_job(served, call):
    record_session(call)
    order = {"sensor": "left", "session": "s1", "method": "preplanar"}
    reply = call.post("/v1/calibrations", json=order)
    assert reply.status_code == 202
    assert reply.headers["Retry-After"] == "1"
    body = reply.json()
    assert reply.headers["Location"] == f"/v1/jobs/{body['job']}"
    assert (body["state"], body["target"], body["method"]) == (
        "solving",
        "dots:7x8:12",
        "preplanar",
    )
    assert body["recordings"] == ["session.s1.left"]
    assert served.queue.submitted == [("calibrate", body["job"])]
    reply = call.get(f"/v1/calibrations/{body['id']}/points")
    assert (reply.status_code, reply.json()["state"]) == (409, "solving")


def test_an_order_may_name_recordings_and_a_target_instead(call):
    record_session(call)
    order = {"sensor": "left", "recordings": ["session.s1.left"], "target": "dots:7x8:12"}
    assert call.post("/v1/calibrations", json=order).status_code == 202


def test_an_order_that_does_not_fit_together_is_refused(call):
    record_session(call)
    call.put("/v1/passes/p1", json={})
    whole = {"sensor": "left", "recordings": ["session.s1.left"], "target": "dots:7x8:12"}
    refusals = {
        422: [
            {"sensor": "left"},
            {**whole, "session": "s1"},
            {**whole, "target": None},
            {**whole, "sensor": "right"},
            {**whole, "method": "guess"},
        ],
        404: [{**whole, "recordings": ["nothing"]}, {"sensor": "left", "session": "s9"}],
        409: [{**whole, "recordings": ["pass.p1.left"]}],
    }
    for status, orders in refusals.items():
        for order in orders:
            assert call.post("/v1/calibrations", json=order).status_code == status, order


def test_a_ready_calibration_gives_its_file_and_its_points(served, call):
    calibration = a_ready_calibration(served, call)
    body = call.get(f"/v1/calibrations/{calibration}").json()
    assert (body["state"], body["document"], body["passed"]) == ("ready", {"sensor": "left"}, True)
    points = call.get(f"/v1/calibrations/{calibration}/points")
    assert points.headers["content-type"].startswith("text/csv")
    assert points.text == "image,kind\n"


def test_of_two_who_change_the_active_calibration_the_slower_one_is_told(served, call):
    first, second = a_ready_calibration(served, call), a_ready_calibration(served, call)
    place = "/v1/sensors/left/active-calibration"
    assert call.get(place).status_code == 404
    tag = call.put(place, json={"calibration": first}).headers["ETag"]
    assert call.get(place).headers["ETag"] == tag
    blind = call.put(place, json={"calibration": second})
    assert blind.status_code == 428
    quick = call.put(place, json={"calibration": second}, headers={"If-Match": tag})
    assert (quick.status_code, quick.json()["version"]) == (200, 2)
    slow = call.put(place, json={"calibration": first}, headers={"If-Match": tag})
    assert slow.status_code == 412
    body = call.get(place).json()
    assert (body["calibration"], body["activated_by"]) == (second, "environment")
    assert call.get("/v1/station").json()["sensors"][0]["active_calibration"] == second
    odd = call.put(place, json={"calibration": first}, headers={"If-Match": "*"})
    assert odd.status_code == 422


def test_what_cannot_come_into_force_is_refused(served, call):
    ready = a_ready_calibration(served, call)
    solving = call.post("/v1/calibrations", json={"sensor": "left", "session": "s1"}).json()["id"]
    place = "/v1/sensors/{}/active-calibration"
    refusals = [("left", solving, 409), ("right", ready, 422), ("left", "none", 404)]
    for sensor, calibration, status in [*refusals, ("middle", ready, 404)]:
        reply = call.put(place.format(sensor), json={"calibration": calibration})
        assert reply.status_code == status


def test_a_cancelled_order_leaves_a_failed_calibration(call):
    record_session(call)
    body = call.post("/v1/calibrations", json={"sensor": "left", "session": "s1"}).json()
    assert call.delete(f"/v1/jobs/{body['job']}").json()["state"] == "cancelled"
    found = call.get(f"/v1/calibrations/{body['id']}").json()
    assert (found["state"], found["reason"]) == ("failed", "cancelled")


def test_a_job_that_has_ended_is_not_cancelled(served, call):
    a_ready_calibration(served, call)
    job = served.queue.submitted[0][1]
    reply = call.delete(f"/v1/jobs/{job}")
    assert (reply.status_code, reply.json()["state"]) == (409, "done")
