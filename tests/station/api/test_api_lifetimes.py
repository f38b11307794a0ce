"""Shows that passes and sessions end without their controller, say so, and take its word later.
Time is the test's; camera and worker are doubles.  That the service itself looks is shown in
tests/station/serve."""

import threading
from dataclasses import replace
from datetime import timedelta

import pytest
from test_api_passes import put_calibration_in_force

from station.errors import StoreUnusable
from station.operations import Lifetimes, Passes, Sessions
from station.operations.strays import close_strays
from station.store import (
    Actor,
    CalibrationSession,
    JobKind,
    Pass,
    PassState,
    Recording,
    SessionState,
    add_job,
    the,
)

PATIENCE_S = 30.0


class Watch:
    """A station's look at its passes, by clocks that the test sets."""

    def __init__(self, served):
        self.served = served
        self.steady_s = 1000.0
        self.wall_off = timedelta(0)
        self.began = served.station.now()
        parts = served.app.state.parts
        self.passes, self.sessions = parts.passes, parts.sessions
        self.begin_anew()

    def begin_anew(self):
        """Forget everything, as a new API process has."""
        station = replace(self.served.station, now=self.now)
        self._lifetimes = Lifetimes(station, self.passes, self.sessions, lambda: self.steady_s)

    def now(self):
        return self.began + timedelta(seconds=self.steady_s - 1000.0) + self.wall_off

    def after(self, seconds, *, silent=True):
        """Let time go by, in which no frame comes, and look."""
        self.steady_s += seconds
        for capture in self.served.captures.values():
            if capture.age_s is not None:
                capture.age_s += seconds
                capture.silent_s = capture.silent_s + seconds if silent else 0.0
        self._lifetimes.look()


class FailingStore:
    """A store that takes so many changes, and then no more."""

    def __init__(self, store, good):
        self._store, self._good = store, good
        self.look = store.look

    def change(self):
        self._good -= 1
        if self._good < 0:
            raise StoreUnusable("the store cannot be used now; try again")
        return self._store.change()


@pytest.fixture
def watch(served):
    return Watch(served)


def open_pass(served, call, name="p1"):
    assert call.put(f"/v1/passes/{name}", json={}).status_code == 201
    for capture in served.captures.values():
        capture.age_s = capture.silent_s = 0.0


def finish(call, body, name="p1"):
    reply = call.post(f"/v1/passes/{name}/finish", json=body)
    return reply.status_code, reply.json()


def frames(body):
    return {each["sensor"]: (each["expected"], each["lost"]) for each in body["recordings"]}


def test_a_pass_that_nobody_finishes_ends_when_it_has_been_quiet(served, call, watch):
    open_pass(served, call)
    served.captures["left"].pictures = 3
    watch.after(60.0, silent=False)
    watch.after(299.0)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    watch.after(1.0)
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["ended_by"]) == ("recorded", "timeout")
    last = (watch.now() - timedelta(seconds=300)).isoformat(timespec="seconds")
    assert body["reason"].startswith(
        f"no finish came, and no frame for 300 s (quiet_s); the last frame came at {last}; not "
    )
    assert frames(body) == {"left": (None, 0), "right": (None, 0)}
    newest = call.get("/v1/audit", params={"subject": "p1"}).json()["entries"][0]
    assert (newest["who"], newest["action"]) == ("station", "finish")
    assert newest["after"]["ended_by"] == "timeout"
    assert call.put("/v1/passes/p2", json={}).status_code == 201


def test_a_pass_in_which_frames_never_end_is_ended_after_the_longest_time(served, call, watch):
    open_pass(served, call)
    for _ in range(17):
        watch.after(100.0, silent=False)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    watch.after(100.0, silent=False)
    body = call.get("/v1/passes/p1").json()
    assert body["ended_by"] == "timeout"
    assert "within 1800 s (pass_longest_s) of its arming" in body["reason"]


def test_an_api_that_is_started_again_every_minute_keeps_no_pass_open(served, call, watch):
    open_pass(served, call)
    for _ in range(5):
        watch.begin_anew()
        watch.after(59.0)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    watch.begin_anew()
    watch.after(5.0)
    assert call.get("/v1/passes/p1").json()["ended_by"] == "timeout"


@pytest.mark.parametrize("days", [-1, 1])
def test_a_step_of_the_wall_clock_neither_ends_a_pass_nor_keeps_it(served, call, watch, days):
    open_pass(served, call)
    watch.after(1.0)
    watch.wall_off = timedelta(days=days)
    watch.after(298.0)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    watch.after(1.0)
    assert call.get("/v1/passes/p1").json()["ended_by"] == "timeout"


def test_without_a_word_of_any_sensor_the_time_since_the_arming_counts(served, call, watch):
    open_pass(served, call)
    watch.after(10.0)
    for capture in served.captures.values():
        capture.plan, capture.broken = None, "no camera answers"  # started again, to no avail
    watch.after(289.0)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    served.saved["left"] = 2
    watch.after(1.0)
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["ended_by"]) == ("recorded", "timeout")
    assert "no longer recorded by left, right" in body["reason"]
    assert [each["recorded"] for each in body["recordings"]] == [2, 0]


@pytest.mark.parametrize("what", ["a dead capture", "a full disk"])
def test_a_pass_ends_with_what_there_is(served, call, watch, what):
    open_pass(served, call)
    left = served.captures["left"]
    if what == "a dead capture":
        left.broken, served.saved["left"] = "the capture process does not answer", 3
    else:
        left.lost = 1  # of four: the disk took no more
    watch.after(300.0)
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["ended_by"]) == ("recorded", "timeout")
    assert [each["recorded"] for each in body["recordings"]] == [3, 4]
    assert not body["recordings"][0]["complete"]


def test_a_late_finish_brings_in_what_was_counted_once(served, call, watch):
    open_pass(served, call)
    served.captures["right"].wheels = 3
    watch.after(300.0)
    for _ in range(2):
        status, body = finish(call, {"axles": 5, "triggers": {"left": 4}})
        assert (status, body["state"], body["ended_by"]) == (200, "recorded", "timeout")
        assert body["axles"] == 5
        assert frames(body) == {"left": (4, 0), "right": (5, 2)}
    assert [each["complete"] for each in body["recordings"]] == [True, False]
    assert body["recordings"][1]["summary"].endswith(
        "5 triggered, as was told later, 2 of them without a trace"
    )
    told = call.get("/v1/audit", params={"subject": "p1"}).json()["entries"]
    assert [each["who"] for each in told] == ["environment", "station", "environment"]

    for other in ({"axles": 6}, {"triggers": {"left": 5}}):
        status, problem = finish(call, other)
        assert (status, problem["state"]) == (409, "recorded")
        assert "what was counted is told once" in problem["detail"]
    assert call.get("/v1/passes/p1").json() == body


@pytest.mark.parametrize("state", [PassState.RECORDED, PassState.DONE, PassState.RECOVERED])
def test_a_late_finish_names_the_axles(served, call, watch, state):
    open_pass(served, call)
    watch.after(300.0)
    with served.store.change() as session:
        the(session, Pass, "p1").state = state
    assert call.get("/v1/passes/p1/wheels").json()["axles"] == []
    status, body = finish(call, {"axles": 2, "consist": ["w1", "w2"]})
    assert (status, body["state"]) == (200, state.value)
    axles = call.get("/v1/passes/p1/wheels").json()["axles"]
    assert len(axles) == 2
    status, problem = finish(call, {"consist": ["w2", "w1"]})
    assert (status, problem["state"]) == (409, state.value)


def test_a_late_finish_of_a_pass_without_a_frame_is_told_that_it_failed(served, call, watch):
    for capture in served.captures.values():
        capture.wheels = 0
    open_pass(served, call)
    watch.after(300.0)
    for _ in range(2):
        status, body = finish(call, {"axles": 4})
        assert (status, body["state"], body["ended_by"]) == (200, "failed", "timeout")
        assert frames(body) == {"left": (4, 4), "right": (4, 4)}


def test_a_finish_that_meets_the_time_out_ends_the_pass_once(served, call, watch):
    open_pass(served, call)
    served.captures["left"].gate = threading.Event()
    ending = threading.Thread(target=watch.after, args=(300.0,))
    ending.start()
    replies = []
    with served.client() as other:
        late = threading.Thread(target=lambda: replies.append(finish(other, {"axles": 4})))
        late.start()
        served.captures["left"].gate.set()
        ending.join(PATIENCE_S)
        late.join(PATIENCE_S)
    ((status, body),) = replies
    assert (status, body["state"], body["axles"]) == (200, "recorded", 4)
    ends = [
        each["after"]
        for each in call.get("/v1/audit", params={"subject": "p1"}).json()["entries"]
        if each["action"] == "finish"
    ]
    # Whoever came first; the other one found the pass ended and brought the count alone.
    by_station = [after for after in ends if "ended_by" in after]
    assert len(by_station) == (1 if body["ended_by"] == "timeout" else 0)


def test_a_pass_left_armed_by_a_store_that_failed_goes_on(served, call, watch):
    open_pass(served, call)
    with served.store.change() as session:
        the(session, Pass, "p1").state = PassState.ARMED
    assert finish(call, {})[0] == 409
    watch.after(1.0)
    assert call.get("/v1/passes/p1").json()["state"] == "recording"


def test_a_finish_that_was_cut_off_is_gone_on_with_by_its_own_count(served, call, watch):
    open_pass(served, call)
    station = replace(served.station, store=FailingStore(served.store, good=1))
    with pytest.raises(StoreUnusable):
        Passes(station).finish("p1", axles=6, triggers={"right": 5}, by=Actor("plc"))
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    assert not watch.passes.end_overdue("p1", "a time-out that was found before the finish came")
    served.saved.update(left=4, right=4)
    watch.after(1.0)
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["ended_by"], body["axles"]) == ("recorded", "controller", 6)
    assert frames(body) == {"left": (6, 2), "right": (5, 1)}


def test_a_pass_that_one_sensor_still_records_goes_on_after_a_start(served, call):
    open_pass(served, call)
    served.captures["left"].plan = None
    Passes(served.station).take_up()
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    served.saved["left"] = 2
    _, body = finish(call, {"axles": 4})
    assert frames(body) == {"left": (4, 2), "right": (4, 0)}


def test_a_pass_that_no_sensor_records_is_ended_by_the_start_and_takes_a_late_count(served, call):
    open_pass(served, call)
    for capture in served.captures.values():
        capture.plan = None
    served.saved["left"] = 3
    Passes(served.station).take_up()
    body = call.get("/v1/passes/p1").json()
    assert (body["state"], body["ended_by"]) == ("recorded", "restart")
    assert body["reason"].startswith("no sensor recorded it any more when the station took it up")
    status, body = finish(call, {"axles": 4})
    assert (status, body["ended_by"], frames(body)["left"]) == (200, "restart", (4, 1))


def test_sensors_that_an_api_died_before_arming_are_armed_by_the_next(served, call):
    open_pass(served, call)
    with served.store.change() as session:
        the(session, Pass, "p1").state = PassState.ARMED
    served.captures["right"].plan = None
    Passes(served.station).take_up()
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    assert served.captures["right"].plan is not None


def test_a_sensor_that_went_on_when_its_pass_had_ended_is_closed_and_its_frames_listed(
    served, call, watch
):
    open_pass(served, call)
    left = served.captures["left"]
    left.broken = "the capture process does not answer"
    _, body = finish(call, {"axles": 4})
    assert frames(body) == {"left": (4, 4), "right": (4, 0)}
    left.broken = None  # it was stuck, and goes on with the pass that has ended
    assert left.plan is not None
    watch.after(1.0)
    assert left.plan is None
    body = call.get("/v1/passes/p1").json()
    assert frames(body) == {"left": (4, 0), "right": (4, 0)}
    assert call.put("/v1/passes/p2", json={}).status_code == 201
    watch.after(1.0)
    assert left.plan is not None  # what is wanted is left alone


def test_what_is_recorded_for_a_pass_that_the_store_does_not_know_is_closed_and_listed(
    served, call, watch
):
    open_pass(served, call, "lost")
    with served.store.change() as session:  # as in a store that was restored from a backup
        for recording in session.query(Recording):
            session.delete(recording)
        session.flush()
        session.delete(the(session, Pass, "lost"))
    watch.after(1.0)
    assert all(capture.plan is None for capture in served.captures.values())
    listed = call.get("/v1/recordings").json()["recordings"]
    assert {each["id"].rsplit(".", 1)[0] for each in listed} == {
        "stray.lost.left",
        "stray.lost.right",
    }
    assert {each["recorded"] for each in listed} == {4}


def test_a_sensor_that_was_armed_for_the_next_pass_meanwhile_is_no_stray(served, call):
    open_pass(served, call)
    seen = {name: capture.status() for name, capture in served.captures.items()}
    finish(call, {"axles": 4})
    open_pass(served, call, "p2")
    assert close_strays(served.station, seen) == []
    assert all(capture.plan is not None for capture in served.captures.values())


def test_cancelling_a_job_takes_no_pass_off_its_sensors(served, call):
    open_pass(served, call)
    with served.store.change() as session:
        add_job(session, "early", JobKind.MEASURE, "p1", at=served.station.now())
    assert call.delete("/v1/jobs/early").json()["state"] == "cancelled"
    assert call.get("/v1/passes/p1").json()["state"] == "recording"


SESSION = "/v1/calibration-sessions/s1"
ORDER = {"sensor": "left", "target": "dots:7x8:12"}


@pytest.mark.parametrize(("pictures", "state"), [(2, "recorded"), (0, "failed")])
def test_a_session_that_nobody_finishes_ends_by_itself(served, call, watch, pictures, state):
    left = served.captures["left"]
    left.wheels = 0
    assert call.put(SESSION, json=ORDER).status_code == 201
    left.age_s = left.silent_s = 0.0
    for _ in range(pictures):
        call.post(f"{SESSION}/capture")
    watch.after(3599.0)
    assert call.get(SESSION).json()["state"] == "open"
    watch.after(1.0)
    body = call.get(SESSION).json()
    assert (body["state"], body["ended_by"]) == (state, "timeout")
    assert "no picture for 3600 s (session_quiet_s)" in body["reason"]
    late = call.post(f"{SESSION}/finish")
    assert (late.status_code, late.json()) == (200, body)
    assert call.put("/v1/passes/p1", json={}).status_code == 201


def test_a_session_left_armed_is_open_after_a_start(served, call):
    call.put(SESSION, json=ORDER)
    with served.store.change() as session:
        the(session, CalibrationSession, "s1").state = SessionState.ARMED
    assert call.post(f"{SESSION}/finish").status_code == 409
    Sessions(served.station).take_up()
    assert call.post(f"{SESSION}/finish").json()["state"] == "recorded"


def test_a_timed_out_pass_is_measured_and_keeps_saying_why_it_ended(served, call, watch):
    put_calibration_in_force(served, "left")
    open_pass(served, call)
    watch.after(300.0)
    body = call.get("/v1/passes/p1").json()
    assert body["state"] == "measuring"
    assert served.queue.submitted == [("measure", body["job"])]
    with served.store.change() as session:  # as the worker does when it is done
        the(session, Pass, "p1").state = PassState.DONE
        the(session, Pass, "p1").reason = "of the measuring"
    reason = call.get("/v1/passes/p1").json()["reason"]
    assert reason.startswith("no finish came")
    assert reason.endswith("; of the measuring")
