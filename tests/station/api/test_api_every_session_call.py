"""Shows what every call does to a calibration session in every state: the answer, and the state it
leaves behind.  A state or a call without its entry fails.  Camera and worker are doubles."""

from itertools import count

import pytest
from served_station import Served

from station.store import CalibrationSession, SessionState, the

NAMES = count(1)
ORDER = {"sensor": "left", "target": "dots:7x8:12"}


class Ground:
    """A station on which a session is brought into any state."""

    def __init__(self, served, call):
        self.served, self.call = served, call

    def put(self, order=ORDER):
        return self.call.put(self.place, json=order)

    def begin(self):
        self.name = f"s{next(NAMES)}"
        self.place = f"/v1/calibration-sessions/{self.name}"
        self.put()

    def armed(self):
        self.begin()
        self._be(SessionState.ARMED)

    def open(self):
        self.begin()

    def recorded(self):
        self.begin()
        self.call.post(f"{self.place}/capture")
        self.call.post(f"{self.place}/finish")

    def timed_out(self):
        self.served.captures["left"].wheels = 0  # as the doubles call what they see
        self.begin()
        self.served.app.state.parts.sessions.end_overdue(self.name, "no finish came")

    def not_armed(self):
        self.served.captures["left"].broken = "no camera answers"
        self.begin()
        self.served.captures["left"].broken = None

    def settle(self):
        """Free the sensor for the next."""
        self.served.captures["left"].wheels = 4
        if self.call.get(self.place).json()["state"] == SessionState.ARMED:
            self._be(SessionState.OPEN)
        self.call.post(f"{self.place}/finish")

    def _be(self, state):
        with self.served.store.change() as session:
            the(session, CalibrationSession, self.name).state = state


CALLS = {
    "put again": lambda on: on.put(),
    "put with another target": lambda on: on.put({**ORDER, "target": "dots:7x8:6"}),
    "capture": lambda on: on.call.post(f"{on.place}/capture"),
    "finish": lambda on: on.call.post(f"{on.place}/finish"),
    "get": lambda on: on.call.get(on.place),
}
SITUATIONS = {
    "armed": SessionState.ARMED,
    "open": SessionState.OPEN,
    "recorded": SessionState.RECORDED,
    "timed_out": SessionState.FAILED,
    "not_armed": SessionState.FAILED,
}
"""How a session may stand, and the state it then is in."""

# In the order of CALLS: the status of the answer, with the state afterwards where it is another.
TABLE = {
    "armed": [200, 409, 409, 409, 200],
    "open": [200, 409, 200, (200, "recorded"), 200],
    "recorded": [200, 409, 409, 200, 200],
    "timed_out": [409, 409, 409, 200, 200],
    "not_armed": [409, 409, 409, 409, 200],
}
CASES = [(situation, call) for situation in SITUATIONS for call in CALLS]


@pytest.fixture(scope="module")
def ground(tmp_path_factory, empty_store):
    served = Served(tmp_path_factory.mktemp("ground"), empty_store)
    with served.client() as call:
        yield Ground(served, call)
    served.close()


def test_every_state_and_every_call_of_a_session_has_its_entry():
    assert set(SITUATIONS.values()) == set(SessionState)
    assert {name: len(entries) for name, entries in TABLE.items()} == dict.fromkeys(
        SITUATIONS, len(CALLS)
    )


@pytest.mark.parametrize(("situation", "called"), CASES)
def test_a_call_does_to_a_session_what_the_table_says(ground, situation, called):
    entry = TABLE[situation][list(CALLS).index(called)]
    before = SITUATIONS[situation]
    status, after = entry if isinstance(entry, tuple) else (entry, before.value)
    getattr(ground, situation)()
    try:
        assert ground.call.get(ground.place).json()["state"] == before
        answer = CALLS[called](ground)
        found = ground.call.get(ground.place).json()
    finally:
        ground.settle()
    assert (answer.status_code, found["state"]) == (status, after), answer.text
    if status == 409:
        assert answer.json()["state"] == before
