"""Shows that a pass goes its way however often and in whatever order a controller calls.  Camera
and worker are doubles: that frames and readings are right is shown elsewhere."""

import threading
import time

from station.operations import Passes
from station.store import (
    Activation,
    Calibration,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    the,
)


def put_calibration_in_force(served, sensor, *, calibration_id=None):
    calibration_id = calibration_id or f"of-{sensor}"
    now = served.station.now()
    with served.store.change() as session:
        session.add(
            Calibration(
                id=calibration_id,
                state=CalibrationState.READY,
                sensor=sensor,
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=now,
                job_id="j",
                document='{"sensor": "%s"}' % sensor,  # noqa: UP031  braces
            )
        )
        session.flush()
        session.add(
            Activation(
                sensor=sensor,
                version=1,
                calibration_id=calibration_id,
                activated_at=now,
                activated_by="test",
            )
        )


def test_a_pass_is_armed_on_every_sensor_and_finished_against_the_count(served, call):
    reply = call.put("/v1/passes/p1", json={"train": "IC 5"})
    assert reply.status_code == 201
    assert reply.json()["state"] == "recording"
    assert {plan.sensor for c in served.captures.values() for plan in c.plans} == {"left", "right"}

    served.captures["right"].lost = 1
    body = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()
    assert body["state"] == "recorded"
    accounts = {
        r["sensor"]: (r["expected"], r["recorded"], r["lost"], r["complete"])
        for r in body["recordings"]
    }
    assert accounts == {"left": (4, 4, 0, True), "right": (4, 3, 1, False)}
    assert "no sensor had an active calibration" in body["reason"]
    assert call.get("/v1/passes/p1").json() == body


def test_calling_twice_arms_once_and_answers_the_same(served, call):
    first = call.put("/v1/passes/p1", json={})
    again = call.put("/v1/passes/p1", json={})
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json() == again.json()
    finished = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()
    assert call.post("/v1/passes/p1/finish", json={"axles": 4}).json() == finished
    # A duplicate of the first call that comes late must not start another recording.
    late = call.put("/v1/passes/p1", json={})
    assert (late.status_code, late.json()) == (200, finished)
    assert len(served.captures["left"].plans) == 1


def test_a_second_train_is_refused_while_one_is_recorded(call):
    call.put("/v1/passes/p1", json={})
    reply = call.put("/v1/passes/p2", json={})
    assert reply.status_code == 409
    problem = reply.json()
    assert problem["state"] == "recording"
    assert "pass p1 is recording" in problem["detail"]
    call.post("/v1/passes/p1/finish", json={})
    assert call.put("/v1/passes/p2", json={}).status_code == 201


def test_one_id_for_two_trains_is_refused(call):
    call.put("/v1/passes/p1", json={"train": "IC 5"})
    reply = call.put("/v1/passes/p1", json={"train": "IC 6"})
    assert (reply.status_code, reply.json()["state"]) == (409, "recording")


def test_many_equal_calls_at_once_make_one_pass(served):
    replies = []

    def put():
        with served.client() as client:
            replies.append(client.put("/v1/passes/p1", json={}).status_code)

    callers = [threading.Thread(target=put) for _ in range(8)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert sorted(replies) == [200] * 7 + [201]
    assert len(served.captures["left"].plans) == 1


def test_a_finish_that_comes_while_another_runs_gets_the_same_answer(served, call):
    call.put("/v1/passes/p1", json={})
    served.captures["left"].gate = threading.Event()
    replies = []

    def finish():
        with served.client() as client:
            replies.append(client.post("/v1/passes/p1/finish", json={"axles": 4}).json())

    callers = [threading.Thread(target=finish) for _ in range(3)]
    for caller in callers:
        caller.start()
    time.sleep(0.5)  # by then all three are in, or wait before the door
    served.captures["left"].gate.set()
    for caller in callers:
        caller.join()
    assert replies[0]["state"] == "recorded"
    assert replies[1:] == replies[:1] * 2


def test_a_sensor_that_does_not_arm_fails_the_pass_and_frees_the_other(served, call):
    served.captures["right"].broken = "127.0.0.3: no camera answers"
    reply = call.put("/v1/passes/p1", json={})
    assert reply.status_code == 503
    assert "Retry-After" in reply.headers
    assert "127.0.0.3: no camera answers" in reply.json()["detail"]
    assert served.captures["left"].plan is None
    assert call.get("/v1/passes/p1").json()["state"] == "failed"

    served.captures["right"].broken = None
    again = call.put("/v1/passes/p1", json={})  # the left one had seen wheels by then
    assert (again.status_code, again.json()["state"]) == (409, "failed")
    assert call.post("/v1/passes/p1/finish", json={}).status_code == 409
    assert call.put("/v1/passes/p2", json={}).status_code == 201


def test_a_pass_of_which_nothing_was_recorded_is_armed_by_the_same_call_again(served, call):
    served.captures["left"].wheels = 0
    served.captures["right"].broken = "127.0.0.3: no camera answers"
    body = {"train": "IC 5", "consist": ["w1", "w2"]}
    for _ in range(2):
        assert call.put("/v1/passes/p1", json=body).status_code == 503
    served.captures["left"].wheels, served.captures["right"].broken = 4, None
    put_calibration_in_force(served, "left")
    assert call.put("/v1/passes/p1", json=body | {"train": "IC 6"}).status_code == 409
    assert call.put("/v1/passes/p1", json={"train": "IC 5"}).status_code == 409
    reply = call.put("/v1/passes/p1", json=body)
    assert (reply.status_code, reply.json()["state"]) == (201, "recording")
    assert (reply.json()["reason"], reply.json()["finished_at"]) == (None, None)
    left = reply.json()["recordings"][0]
    assert (left["recorded"], left["calibration"] is None) == (None, False)
    assert call.put("/v1/passes/p1", json=body).status_code == 200
    assert call.post("/v1/passes/p1/finish", json={"axles": 4}).json()["state"] == "measuring"
    told = call.get("/v1/audit", params={"subject": "p1"}).json()["entries"]
    assert [each["action"] for each in told] == ["finish", "arm", "arm", "arm"]


def test_with_a_calibration_in_force_a_finished_pass_is_given_to_the_worker(served, call):
    put_calibration_in_force(served, "left")
    call.put("/v1/passes/p1", json={})
    assert served.captures["left"].plans[0].attachments == {
        "calibration.json": b'{"sensor": "left"}'
    }
    body = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()
    assert body["state"] == "measuring"
    assert served.queue.submitted == [("measure", body["job"])]
    job = call.get(f"/v1/jobs/{body['job']}").json()
    assert (job["kind"], job["subject"], job["state"]) == ("measure", "p1", "queued")


def test_no_axle_and_no_frame_is_a_pass_that_is_done(served, call):
    for capture in served.captures.values():
        capture.wheels = 0
    call.put("/v1/passes/p1", json={})
    body = call.post("/v1/passes/p1/finish", json={"axles": 0}).json()
    assert (body["state"], body["reason"]) == ("done", "no wheel went by")


def test_axles_without_any_frame_fail_the_pass(served, call):
    for capture in served.captures.values():
        capture.wheels = 0
    call.put("/v1/passes/p1", json={})
    body = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()
    assert body["state"] == "failed"
    assert "no frame was recorded" in body["reason"]
    assert call.put("/v1/passes/p1", json={}).status_code == 409  # it had been recorded


def test_triggers_of_a_single_sensor_win_over_the_axles(call):
    call.put("/v1/passes/p1", json={})
    reply = call.post("/v1/passes/p1/finish", json={"axles": 4, "triggers": {"right": 6}})
    lost = {r["sensor"]: r["lost"] for r in reply.json()["recordings"]}
    assert lost == {"left": 0, "right": 2}
    assert call.put("/v1/passes/p2", json={}).status_code == 201
    reply = call.post("/v1/passes/p2/finish", json={"triggers": {"middle": 6}})
    assert reply.status_code == 422
    assert "the station has left, right" in reply.json()["detail"]
    assert call.get("/v1/passes/p2").json()["state"] == "recording"


def test_a_capture_that_died_leaves_a_recovered_recording(served, call):
    put_calibration_in_force(served, "left")
    call.put("/v1/passes/p1", json={})
    served.captures["left"].plan = None  # the process was started again: it records nothing
    served.saved["left"] = 3
    body = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()
    left, right = body["recordings"]
    assert (left["recovered"], left["recorded"], left["lost"]) == (True, 3, 1)
    assert (right["recovered"], right["recorded"], right["lost"]) == (False, 4, 0)
    assert body["state"] == "measuring"


def test_a_new_api_process_leaves_a_pass_alone_that_is_still_recorded(served, call):
    call.put("/v1/passes/p1", json={})
    Passes(served.station).take_up()
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    assert call.post("/v1/passes/p1/finish", json={"axles": 4}).json()["state"] == "recorded"


def test_a_new_api_process_closes_a_pass_that_nobody_records_any_more(served, call):
    put_calibration_in_force(served, "left")
    call.put("/v1/passes/p1", json={})
    for capture in served.captures.values():
        capture.plan = None
    served.saved["left"] = 2
    Passes(served.station).take_up()
    body = call.get("/v1/passes/p1").json()
    assert body["state"] == "measuring"
    assert [r["recorded"] for r in body["recordings"]] == [2, 0]
    assert served.queue.submitted == [("measure", body["job"])]
    assert call.put("/v1/passes/p2", json={}).status_code == 201


def test_a_pass_that_was_only_armed_when_the_api_died_goes_on_if_its_sensors_record(served, call):
    call.put("/v1/passes/p1", json={})
    with served.store.change() as session:
        the(session, Pass, "p1").state = PassState.ARMED
    reply = call.post("/v1/passes/p1/finish", json={})
    assert (reply.status_code, reply.json()["state"]) == (409, "armed")
    Passes(served.station).take_up()
    assert call.get("/v1/passes/p1").json()["state"] == "recording"


def test_wheels_of_a_pass_are_those_of_the_calibration_it_was_recorded_under(served, call):
    put_calibration_in_force(served, "left")
    call.put("/v1/passes/p1", json={})
    call.post("/v1/passes/p1/finish", json={"axles": 4})
    with served.store.change() as session:
        session.add(
            Calibration(
                id="later",
                state=CalibrationState.READY,
                sensor="left",
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=served.station.now(),
                job_id="j2",
            )
        )
        session.flush()
        for frame, calibration in ((7, "of-left"), (9, "of-left"), (7, "later")):
            session.add(
                Measurement(
                    recording_id="pass.p1.left",
                    frame=frame,
                    calibration_id=calibration,
                    sensor="left",
                    pass_id="p1",
                    reference="S1002",
                    software="treadline 0",
                    measured_at=served.station.now(),
                    wheel={"frame": frame},
                )
            )
    body = call.get("/v1/passes/p1/wheels").json()
    assert body["state"] == "measuring"
    assert [(w["frame"], w["calibration"]) for w in body["wheels"]] == [
        (7, "of-left"),
        (9, "of-left"),
    ]
    page = call.get("/v1/measurements", params={"pass": "p1", "sensor": "left", "limit": 2}).json()
    rest = call.get("/v1/measurements", params={"pass": "p1", "after": page["next"]}).json()
    assert [m["frame"] for m in page["measurements"] + rest["measurements"]] == [7, 9, 7]
    assert rest["next"] is None
    assert call.get("/v1/measurements", params={"sensor": "right"}).json()["measurements"] == []


def test_cancelling_the_measuring_gives_the_recording_back(served, call):
    put_calibration_in_force(served, "left")
    call.put("/v1/passes/p1", json={})
    job = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()["job"]
    assert call.delete(f"/v1/jobs/{job}").json()["state"] == "cancelled"
    assert call.delete(f"/v1/jobs/{job}").json()["state"] == "cancelled"
    assert served.queue.cancelled == [job]
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["reason"]) == ("recorded", "its measuring was cancelled")


def test_recordings_are_listed_newest_first_and_found_by_id(call):
    for name in ("p1", "p2", "p3"):
        call.put(f"/v1/passes/{name}", json={})
        call.post(f"/v1/passes/{name}/finish", json={"axles": 4})
    page = call.get("/v1/recordings", params={"limit": 4}).json()
    rest = call.get("/v1/recordings", params={"limit": 4, "before": page["next"]}).json()
    names = [r["id"] for r in page["recordings"] + rest["recordings"]]
    assert names == [f"pass.{p}.{s}" for p in ("p3", "p2", "p1") for s in ("right", "left")]
    assert rest["next"] is None
    one = call.get("/v1/recordings/pass.p2.left").json()
    assert (one["pass_id"], one["recorded"]) == ("p2", 4)
    assert call.get("/v1/recordings/pass.p9.left").status_code == 404
    assert call.get("/v1/recordings", params={"before": "yesterday"}).status_code == 422
