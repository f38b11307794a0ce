"""Shows what every call does to a pass in every state: the answer, and the state it leaves behind.
A state or a call without its entry fails.  Camera and worker are doubles."""

from itertools import count

import pytest
from served_station import Served
from test_api_passes import put_calibration_in_force

from station.store import Job, JobState, Pass, PassState, the

NAMES = count(1)
CONSIST = {"consist": ["w1", "w2", "w3", "w4"]}


class Ground:
    """A station on which a pass is brought into any state; its left sensor is calibrated."""

    def __init__(self, served, call):
        self.served, self.call = served, call
        put_calibration_in_force(served, "left")

    def put(self):
        self.name = f"p{next(NAMES)}"
        return self.call.put(f"/v1/passes/{self.name}", json={"train": "IC 5"})

    def finish(self, body):
        return self.call.post(f"/v1/passes/{self.name}/finish", json=body)

    @property
    def job(self):
        return self.call.get(f"/v1/passes/{self.name}").json()["job"]

    def armed(self):
        self.put()
        self._be(PassState.ARMED)

    def recording(self):
        self.put()

    def recorded(self):
        self.served.captures["left"].wheels = 0  # it alone could be measured
        self.put()
        self.finish({"axles": 4})

    def measuring(self):
        self.put()
        self.finish({"axles": 4})

    def done(self):
        self._measured(PassState.DONE, JobState.DONE)

    def recovered(self):
        self._measured(PassState.RECOVERED, JobState.DONE)

    def failed(self):
        self._measured(PassState.FAILED, JobState.FAILED)

    def not_armed(self):
        self.served.captures["left"].wheels = 0
        self.not_armed_with_frames()

    def not_armed_with_frames(self):
        self.served.captures["right"].broken = "no camera answers"
        self.put()
        self.served.captures["right"].broken = None

    def timed_out(self):
        self.put()
        self.served.app.state.parts.passes.end_overdue(self.name, "no finish came")

    def settle(self):
        """Free the sensors for the next."""
        for capture in self.served.captures.values():
            capture.wheels = 4
        if self._state() is PassState.ARMED:
            self._be(PassState.RECORDING)
        if self._state() is PassState.RECORDING:
            self.finish({})

    def _measured(self, state, ended):
        self.measuring()
        self._be(state)
        with self.served.store.change() as session:
            the(session, Job, the(session, Pass, self.name).job_id).state = ended

    def _be(self, state):
        with self.served.store.change() as session:
            the(session, Pass, self.name).state = state

    def _state(self):
        with self.served.store.look() as session:
            return the(session, Pass, self.name).state


CALLS = {
    "put again": lambda on: on.call.put(f"/v1/passes/{on.name}", json={"train": "IC 5"}),
    "put of another train": lambda on: on.call.put(f"/v1/passes/{on.name}", json={"train": "x"}),
    "finish without a count": lambda on: on.finish({}),
    "finish with the count": lambda on: on.finish({"axles": 4}),
    "finish with another count": lambda on: on.finish({"axles": 7}),
    "finish with a consist": lambda on: on.finish(CONSIST),
    "cancel its job": lambda on: on.call.delete(f"/v1/jobs/{on.job}"),
    "get": lambda on: on.call.get(f"/v1/passes/{on.name}"),
    "get its wheels": lambda on: on.call.get(f"/v1/passes/{on.name}/wheels"),
}
SITUATIONS = {
    "armed": PassState.ARMED,
    "recording": PassState.RECORDING,
    "recorded": PassState.RECORDED,
    "measuring": PassState.MEASURING,
    "timed_out": PassState.MEASURING,
    "done": PassState.DONE,
    "recovered": PassState.RECOVERED,
    "failed": PassState.FAILED,
    "not_armed": PassState.FAILED,
    "not_armed_with_frames": PassState.FAILED,
}
"""How a pass may stand, and the state it then is in."""

# In the order of CALLS: the status of the answer, with the state afterwards where it is another.
TABLE = {
    "armed": [200, 409, 409, 409, 409, 409, 404, 200, 200],
    "recording": [
        200,
        409,
        (200, "measuring"),
        (200, "measuring"),
        (200, "measuring"),
        (200, "measuring"),
        404,
        200,
        200,
    ],
    "recorded": [200, 409, 200, 200, 409, 200, 404, 200, 200],
    "measuring": [200, 409, 200, 200, 409, 200, (200, "recorded"), 200, 200],
    "timed_out": [200, 409, 200, 200, 200, 200, (200, "recorded"), 200, 200],
    "done": [200, 409, 200, 200, 409, 200, 409, 200, 200],
    "recovered": [200, 409, 200, 200, 409, 200, 409, 200, 200],
    "failed": [409, 409, 200, 200, 409, 200, 409, 200, 200],
    "not_armed": [(201, "recording"), 409, 409, 409, 409, 409, 404, 200, 200],
    "not_armed_with_frames": [409, 409, 409, 409, 409, 409, 404, 200, 200],
}
CASES = [(situation, call) for situation in SITUATIONS for call in CALLS]


@pytest.fixture(scope="module")
def ground(tmp_path_factory, empty_store):
    served = Served(tmp_path_factory.mktemp("ground"), empty_store)
    with served.client() as call:
        yield Ground(served, call)
    served.close()


def test_every_state_and_every_call_has_its_entry():
    assert set(SITUATIONS.values()) == set(PassState)
    assert {name: len(entries) for name, entries in TABLE.items()} == dict.fromkeys(
        SITUATIONS, len(CALLS)
    )


@pytest.mark.parametrize(("situation", "called"), CASES)
def test_a_call_does_to_a_pass_what_the_table_says(ground, situation, called):
    entry = TABLE[situation][list(CALLS).index(called)]
    before = SITUATIONS[situation]
    status, after = entry if isinstance(entry, tuple) else (entry, before.value)
    getattr(ground, situation)()
    try:
        assert ground.call.get(f"/v1/passes/{ground.name}").json()["state"] == before
        answer = CALLS[called](ground)
        found = ground.call.get(f"/v1/passes/{ground.name}").json()
    finally:
        ground.settle()
    assert (answer.status_code, found["state"]) == (status, after), answer.text
    if status == 409:
        of = "failed" if situation == "failed" else "done"
        assert answer.json()["state"] == (of if called == "cancel its job" else before)


@pytest.mark.parametrize("situation", SITUATIONS)
def test_a_call_that_comes_twice_is_answered_the_same(ground, situation):
    for called in CALLS:
        getattr(ground, situation)()
        try:
            first, second = CALLS[called](ground), CALLS[called](ground)
        finally:
            ground.settle()
        told, again = ({**each.json(), "request": None} for each in (first, second))
        made = {201: 200}.get(first.status_code, first.status_code)
        assert (made, told) == (second.status_code, again), called
