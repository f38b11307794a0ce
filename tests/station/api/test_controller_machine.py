"""Shows that a controller that retries blindly can do no harm: its calls come twice, late, in the
wrong order, cut off, and while the API process dies, in every state, and each answer is the one
foreseen.  Cameras and worker are doubles that keep a true log; how those die themselves is
shown elsewhere.
"""

import tempfile
from pathlib import Path

import pytest
from controller_calls import Asked, settle
from controller_conversation import Conversation, post
from controller_model import SENSORS, Model
from controller_reading import read_all
from controller_work import begin, work
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from trackside import Trackside, files_of
from trackside_truths import History, ensure_files_and_rows_agree, ensure_one_at_a_time

from station.store import migrate

PASSES = st.sampled_from(["p1", "p2", "p3"])
SESSIONS = st.sampled_from(["s1", "s2"])
TRAINS = st.sampled_from(["IC 5", "IC 5", "IC 6"])
CONSISTS = st.sampled_from([None, None, None, ["w1", "w2"], ["w3"]])
AXLES = st.sampled_from([None, 0, 2])
SENSOR = st.sampled_from(SENSORS)
KEYS = st.sampled_from([None, None, "k1", "k2", "k3"])
HOW = st.sampled_from(["plain", "plain", "plain", "twice", "half", "unread", "dying"])
DEEDS = st.integers(0, 6)
MOST_PARTS = 3


class Controller(RuleBasedStateMachine):
    """A trackside controller, its people, its worker and its wheels."""

    empty_store: Path
    store_url: str | None = None

    def __init__(self):
        super().__init__()
        self._folder = tempfile.TemporaryDirectory(prefix="treadline-")
        root = Path(self._folder.name)
        if self.store_url is not None:
            migrate(self.fresh_url())
        self.served = Trackside(root, self.empty_store, store_url=self.store_url)
        self.model = Model(self.served.captures, root)
        self.calls = Conversation(self.served, self.model)
        self.history = History()

    @classmethod
    def fresh_url(cls):
        return cls.store_url

    def teardown(self):
        try:
            self.all_ends_well()
        finally:
            self.calls.close()
            self.served.close()
            self._folder.cleanup()

    # -- what the controller asks ----------------------------------------------------------------

    @rule(name=PASSES, train=TRAINS, consist=CONSISTS, how=HOW, deeds=DEEDS)
    def put_pass(self, name, train, consist, how, deeds):
        body = {"train": train} | ({} if consist is None else {"consist": consist})
        asked = Asked("PUT", f"/v1/passes/{name}", body)
        self.calls.ask(asked, how, deeds, lambda: self.model.put_pass(name, train, consist))

    @rule(name=PASSES, axles=AXLES, consist=CONSISTS, key=KEYS, how=HOW, deeds=DEEDS)
    def finish_pass(self, name, axles, consist, key, how, deeds):
        body = {"axles": axles} | ({} if consist is None else {"consist": consist})
        asked = post(f"/v1/passes/{name}/finish", body, key)
        self.calls.ask(asked, how, deeds, lambda: self.model.finish_pass(name, axles, consist))

    @rule(name=SESSIONS, sensor=SENSOR, how=HOW, deeds=DEEDS)
    def put_session(self, name, sensor, how, deeds):
        target = "dots:7x8:12"
        asked = Asked(
            "PUT", f"/v1/calibration-sessions/{name}", {"sensor": sensor, "target": target}
        )
        self.calls.ask(asked, how, deeds, lambda: self.model.put_session(name, sensor, target))

    @rule(name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def capture(self, name, key, how, deeds):
        asked = post(f"/v1/calibration-sessions/{name}/capture", None, key)
        self.calls.ask(asked, how, deeds, lambda: self.model.capture(name))

    @rule(name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def finish_session(self, name, key, how, deeds):
        asked = post(f"/v1/calibration-sessions/{name}/finish", None, key)
        self.calls.ask(asked, how, deeds, lambda: self.model.finish_session(name))

    @rule(sensor=SENSOR, name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def calibrate(self, sensor, name, key, how, deeds):
        asked = post("/v1/calibrations", {"sensor": sensor, "session": name}, key)
        self.calls.ask(asked, how, deeds, lambda: self.model.calibrate(sensor, name))

    @rule(sensor=SENSOR, key=KEYS, how=HOW, deeds=DEEDS)
    def recalibrate(self, sensor, key, how, deeds):
        asked = post("/v1/recalibrations", {"sensor": sensor}, key)
        self.calls.ask(asked, how, deeds, lambda: self.model.recalibrate(sensor))

    @rule(sensor=SENSOR, which=st.integers(0, 3), seen=st.sampled_from([None, 0, 1, 2]), how=HOW)
    def activate(self, sensor, which, seen, how):
        calibration = _one_of(self.model.calibrations, which)
        headers = {} if seen is None else {"If-Match": f'"{seen}"'}
        path = f"/v1/sensors/{sensor}/active-calibration"
        asked = Asked("PUT", path, {"calibration": calibration}, headers)
        self.calls.ask(asked, how, 1, lambda: self.model.activate(sensor, calibration, seen))

    @rule(which=st.integers(0, 5), how=HOW, deeds=DEEDS)
    def cancel(self, which, how, deeds):
        job = _one_of(self.model.jobs, which)
        asked = Asked("DELETE", f"/v1/jobs/{job}")
        self.calls.ask(asked, how, deeds, lambda: self.model.cancel(job))

    @rule(name=PASSES, session=SESSIONS)
    def look(self, name, session):
        for path, known in (
            (f"/v1/passes/{name}", self.model.passes.get(name)),
            (f"/v1/calibration-sessions/{session}", self.model.sessions.get(session)),
        ):
            answer = self.calls.client.get(path)
            assert answer.status_code == (404 if known is None else 200)
            if known is not None:
                assert answer.json()["state"] == known.state
        assert self.calls.client.get("/v1/station").status_code == 200

    # -- what happens to the station -------------------------------------------------------------

    @rule(sensor=SENSOR)
    def wheel_passes(self, sensor):
        self.served.captures[sensor].wheel()

    @rule(sensor=SENSOR)
    def sensor_breaks(self, sensor):
        self.served.captures[sensor].reachable = False

    @rule(sensor=SENSOR)
    def sensor_heals(self, sensor):
        self.served.captures[sensor].reachable = True

    @rule(sensor=SENSOR)
    def capture_process_dies(self, sensor):
        self.served.captures[sensor].die()

    @rule()
    def station_looks(self):
        """A sensor whose process died, and that is there again, goes on with the pass."""
        self.served.look()
        for name, known in self.model.passes.items():
            if known.state == "recording":
                self.ensure_all_record(name)
        self.read()

    def ensure_all_record(self, name):
        """Each sensor that is there records the pass, unless it died too often in it."""
        for sensor, capture in self.served.captures.items():
            path = self.model.root / "recordings" / "passes" / name / f"{sensor}.mcap"
            often = len(files_of(path)) > MOST_PARTS
            if capture.reachable and not often:
                assert capture.plan is not None, sensor
                assert capture.plan.path == path

    @rule(deeds=st.one_of(st.none(), DEEDS))
    def api_dies_at_rest(self, deeds):
        self.calls.begin_again(deeds)

    @precondition(lambda self: "queued" in self.model.jobs.values())
    @rule(which=st.integers(0, 5))
    def worker_begins(self, which):
        job = _one_of([name for name, state in self.model.jobs.items() if state == "queued"], which)
        begin(self.served, job)
        self.read()

    @precondition(lambda self: "running" in self.model.jobs.values())
    @rule(which=st.integers(0, 5), well=st.booleans())
    def worker_ends(self, which, well):
        job = _one_of(
            [name for name, state in self.model.jobs.items() if state == "running"], which
        )
        work(self.served, job, well=well)
        self.read()

    def read(self, *, foreseen=True):
        read_all(self.served, self.model, foreseen=foreseen)

    # -- what must be true at every moment -------------------------------------------------------

    @invariant()
    def nothing_is_lost_or_doubled(self):
        settle(self.served)
        ensure_files_and_rows_agree(self.served)
        ensure_one_at_a_time(self.served)
        self.history.note(self.served)

    # -- the end ---------------------------------------------------------------------------------

    def all_ends_well(self):
        """A controller that behaves, after all that, brings everything to its end."""
        for capture in self.served.captures.values():
            capture.reachable = True
        for name, known in self.model.passes.items():
            if known.state in {"armed", "recording"}:
                self.calls.ask_plainly(
                    post(f"/v1/passes/{name}/finish", {"axles": 0}, None),
                    lambda name=name: self.model.finish_pass(name, 0, None),
                )
        for name, known in self.model.sessions.items():
            if known.state in {"armed", "open"}:
                self.calls.ask_plainly(
                    post(f"/v1/calibration-sessions/{name}/finish", None, None),
                    lambda name=name: self.model.finish_session(name),
                )
        self.read()
        for job, state in list(self.model.jobs.items()):
            if state in {"queued", "running"}:
                work(self.served, job, well=True)
        self.read(foreseen=False)
        resting = {"done", "failed", "recovered", "recorded"}
        assert {known.state for known in self.model.passes.values()} <= resting
        assert not set(self.model.jobs.values()) & {"queued", "running"}
        self.nothing_is_lost_or_doubled()


def _one_of(names, which):
    known = list(names)
    return known[which % len(known)] if known else "none"


def run(machine, *, examples, steps):
    run_state_machine_as_test(
        machine,
        settings=settings(
            max_examples=examples,
            stateful_step_count=steps,
            deadline=None,
            # To shrink what was found would take longer than to read it.
            phases=[Phase.generate],
            report_multiple_bugs=False,
            suppress_health_check=list(HealthCheck),
            print_blob=True,
        ),
    )


@pytest.fixture
def machine(empty_store):
    return type("Controller", (Controller,), {"empty_store": empty_store})


def test_whatever_a_controller_sends_no_recording_is_doubled_or_lost(machine):
    run(machine, examples=6, steps=25)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_whatever_a_controller_sends_for_long_no_recording_is_doubled_or_lost(machine):
    run(machine, examples=400, steps=60)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_on_the_other_database_no_recording_is_doubled_or_lost_either(postgres):
    other = {"empty_store": None, "store_url": postgres.empty_database()}
    fresh = classmethod(lambda _: postgres.empty_database())
    run(type("Controller", (Controller,), {**other, "fresh_url": fresh}), examples=40, steps=40)
