"""Shows that a controller that retries blindly can do no harm: its calls come twice, late, in the
wrong order, cut off, and while the API process dies, in every state, and each answer is the one
foreseen.  Cameras and worker are doubles that keep a true log; how those die themselves is
shown elsewhere.
"""

import tempfile
from pathlib import Path

import pytest
from controller_calls import (
    Asked,
    send,
    send_and_go,
    send_half,
    send_to_the_dying,
    send_twice,
    settle,
)
from controller_model import SENSORS, KnownOrder, KnownPass, KnownSession, Model
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

from station.store import (
    Activation,
    Calibration,
    CalibrationSession,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    end,
    migrate,
    recordings_of,
    start,
    the,
)
from station.trains import Named

PASSES = st.sampled_from(["p1", "p2", "p3"])
SESSIONS = st.sampled_from(["s1", "s2"])
TRAINS = st.sampled_from(["IC 5", "IC 5", "IC 6"])
CONSISTS = st.sampled_from([None, None, None, ["w1", "w2"], ["w3"]])
AXLES = st.sampled_from([None, 0, 2])
SENSOR = st.sampled_from(SENSORS)
KEYS = st.sampled_from([None, None, "k1", "k2", "k3"])
HOW = st.sampled_from(["plain", "plain", "plain", "twice", "half", "unread", "dying"])
DEEDS = st.integers(0, 6)
REFUSED_AT_ONCE, FAILED = 300, 500
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
        self.client = self.served.client()
        self.model = Model(self.served.captures, root)
        self.history = History()
        self.kept = {}
        """Calls and answers by Idempotency-Key."""

    @classmethod
    def fresh_url(cls):
        return cls.store_url

    def teardown(self):
        try:
            self.all_ends_well()
        finally:
            self.client.close()
            self.served.close()
            self._folder.cleanup()

    # -- what the controller asks ----------------------------------------------------------------

    @rule(name=PASSES, train=TRAINS, consist=CONSISTS, how=HOW, deeds=DEEDS)
    def put_pass(self, name, train, consist, how, deeds):
        body = {"train": train} | ({} if consist is None else {"consist": consist})
        asked = Asked("PUT", f"/v1/passes/{name}", body)
        self.ask(asked, how, deeds, lambda: self.model.put_pass(name, train, consist))

    @rule(name=PASSES, axles=AXLES, consist=CONSISTS, key=KEYS, how=HOW, deeds=DEEDS)
    def finish_pass(self, name, axles, consist, key, how, deeds):
        body = {"axles": axles} | ({} if consist is None else {"consist": consist})
        asked = self.post(f"/v1/passes/{name}/finish", body, key)
        self.ask(asked, how, deeds, lambda: self.model.finish_pass(name, axles, consist))

    @rule(name=SESSIONS, sensor=SENSOR, how=HOW, deeds=DEEDS)
    def put_session(self, name, sensor, how, deeds):
        target = "dots:7x8:12"
        asked = Asked(
            "PUT", f"/v1/calibration-sessions/{name}", {"sensor": sensor, "target": target}
        )
        self.ask(asked, how, deeds, lambda: self.model.put_session(name, sensor, target))

    @rule(name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def capture(self, name, key, how, deeds):
        asked = self.post(f"/v1/calibration-sessions/{name}/capture", None, key)
        self.ask(asked, how, deeds, lambda: self.model.capture(name))

    @rule(name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def finish_session(self, name, key, how, deeds):
        asked = self.post(f"/v1/calibration-sessions/{name}/finish", None, key)
        self.ask(asked, how, deeds, lambda: self.model.finish_session(name))

    @rule(sensor=SENSOR, name=SESSIONS, key=KEYS, how=HOW, deeds=DEEDS)
    def calibrate(self, sensor, name, key, how, deeds):
        asked = self.post("/v1/calibrations", {"sensor": sensor, "session": name}, key)
        self.ask(asked, how, deeds, lambda: self.model.calibrate(sensor, name))

    @rule(sensor=SENSOR, key=KEYS, how=HOW, deeds=DEEDS)
    def recalibrate(self, sensor, key, how, deeds):
        asked = self.post("/v1/recalibrations", {"sensor": sensor}, key)
        self.ask(asked, how, deeds, lambda: self.model.recalibrate(sensor))

    @rule(sensor=SENSOR, which=st.integers(0, 3), seen=st.sampled_from([None, 0, 1, 2]), how=HOW)
    def activate(self, sensor, which, seen, how):
        calibration = _one_of(self.model.calibrations, which)
        headers = {} if seen is None else {"If-Match": f'"{seen}"'}
        path = f"/v1/sensors/{sensor}/active-calibration"
        asked = Asked("PUT", path, {"calibration": calibration}, headers)
        self.ask(asked, how, 1, lambda: self.model.activate(sensor, calibration, seen))

    @rule(which=st.integers(0, 5), how=HOW, deeds=DEEDS)
    def cancel(self, which, how, deeds):
        job = _one_of(self.model.jobs, which)
        asked = Asked("DELETE", f"/v1/jobs/{job}")
        self.ask(asked, how, deeds, lambda: self.model.cancel(job))

    @rule(name=PASSES, session=SESSIONS)
    def look(self, name, session):
        for path, known in (
            (f"/v1/passes/{name}", self.model.passes.get(name)),
            (f"/v1/calibration-sessions/{session}", self.model.sessions.get(session)),
        ):
            answer = self.client.get(path)
            assert answer.status_code == (404 if known is None else 200)
            if known is not None:
                assert answer.json()["state"] == known.state
        assert self.client.get("/v1/station").status_code == 200

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
        self.begin_again(deeds)

    @precondition(lambda self: "queued" in self.model.jobs.values())
    @rule(which=st.integers(0, 5))
    def worker_begins(self, which):
        job = _one_of([name for name, state in self.model.jobs.items() if state == "queued"], which)
        with self.served.store.change() as session:
            row = the(session, Job, job)
            start(row, at=self.served.station.now())
            if row.kind == JobKind.RECALIBRATE:
                the(session, Recalibration, row.subject).state = RecalibrationState.RUNNING
        self.read()

    @precondition(lambda self: "running" in self.model.jobs.values())
    @rule(which=st.integers(0, 5), well=st.booleans())
    def worker_ends(self, which, well):
        job = _one_of(
            [name for name, state in self.model.jobs.items() if state == "running"], which
        )
        work(self.served, job, well=well)
        self.read()

    # -- what must be true at every moment -------------------------------------------------------

    @invariant()
    def nothing_is_lost_or_doubled(self):
        settle(self.served)
        ensure_files_and_rows_agree(self.served)
        ensure_one_at_a_time(self.served)
        self.history.note(self.served)

    # -- how a call is made and judged -----------------------------------------------------------

    def post(self, path, body, key):
        return Asked("POST", path, body, {} if key is None else {"Idempotency-Key": key})

    def ask(self, asked, how, deeds, foresee):
        {
            "plain": self.ask_plainly,
            "twice": self.ask_twice,
            "half": self.ask_half,
            "unread": self.ask_unread,
            "dying": lambda *call: self.ask_the_dying(*call, deeds),
        }[how](asked, foresee)
        self.read(foreseen=how != "dying")

    def ask_plainly(self, asked, foresee):
        expected = self.foreseen(asked, foresee)
        self.judge(asked, send(self.client, asked), {expected})

    def ask_twice(self, asked, foresee):
        first = self.foreseen(asked, foresee)
        self.note_kept(asked, first)
        second = self.foreseen(asked, foresee)
        answers = send_twice(self.served, asked)
        # The second may find the first at it: a pass that arms, a key that is being answered.
        early = {409} if asked.keyed or first >= REFUSED_AT_ONCE else set()
        early |= {200} if asked.method == "PUT" else set()
        assert len(answers) == 2
        got = [answer.status_code for answer in answers]
        assert first in got, (asked, got, first)
        got.remove(first)
        assert got[0] in {second} | early, (asked, got, second)
        for answer in answers:
            self.judge(asked, answer, {first, second} | early)

    def ask_half(self, asked, _foresee):
        send_half(self.served, asked)
        settle(self.served)

    def ask_unread(self, asked, foresee):
        if asked.method == "POST" and not asked.keyed:
            asked = self.post(asked.path, asked.body, f"unread-{len(self.kept)}")
        first = self.foreseen(asked, foresee)
        send_and_go(self.served, asked)
        settle(self.served)
        self.note_kept(asked, first)
        second = self.foreseen(asked, foresee)
        # The station may have found the caller gone before it had read what it asked.
        self.judge(asked, send(self.client, asked), {first, second})

    def ask_the_dying(self, asked, foresee, deeds):
        first = self.foreseen(asked, foresee)
        self.served.life.end_after(deeds)
        send_to_the_dying(self.served, asked)
        self.begin_again(None)
        if asked.method != "POST" or asked.keyed:
            # As if it were the first, where it finds what it did; or as things are now.
            expected = {first, self.foreseen(asked, foresee)}
            self.judge(asked, send(self.client, asked), expected)

    def begin_again(self, deeds):
        self.client.close()
        self.served.kill_and_begin_again(deeds)
        self.client = self.served.client()
        self.read(foreseen=False)
        begun = [*self.model.passes.values(), *self.model.sessions.values()]
        assert "armed" not in {known.state for known in begun}, "a start left something half done"

    def foreseen(self, asked, foresee):
        known = self.kept.get(asked.headers.get("Idempotency-Key"))
        if known is None or known == (asked, None, None):
            return foresee()
        return known[1] if known[0] == asked else 422

    def note_kept(self, asked, status):
        if asked.keyed and status < REFUSED_AT_ONCE:
            self.kept.setdefault(asked.headers["Idempotency-Key"], (asked, status, None))

    def judge(self, asked, answer, expected):
        told = (asked, answer.status_code, answer.text, expected)
        assert answer.status_code in expected, told
        key = asked.headers.get("Idempotency-Key")
        if answer.status_code >= REFUSED_AT_ONCE:
            assert answer.json()["detail"], told
            self.note_refused(asked, key, failed=answer.status_code >= FAILED)
        elif key is not None:
            _, status, before = self.kept.get(key, (asked, None, None))
            assert before in {None, answer.text}, (asked, before, answer.text)
            self.kept[key] = (asked, status or answer.status_code, answer.text)

    def note_refused(self, asked, key, *, failed):
        """A refusal frees the key; a failure may have done something, and keeps it."""
        if key is not None and failed:
            self.kept.setdefault(key, (asked, None, None))
        elif self.kept.get(key) == (asked, None, None):
            del self.kept[key]

    def read(self, *, foreseen=True):
        """Take over what the store has; where all was foreseen it has nothing else."""
        settle(self.served)
        with self.served.store.look() as session:
            self.read_passes(session, foreseen=foreseen)
            self.read_sessions(session, foreseen=foreseen)
            self.read_orders(session)
            self.model.jobs = {row.id: row.state.value for row in session.query(Job)}
            versions = session.query(Activation).order_by(Activation.version)
            self.model.in_force = {row.sensor: row.version for row in versions}

    def read_passes(self, session, *, foreseen):
        rows = {row.id: row for row in session.query(Pass)}
        if foreseen:
            assert {name: row.state.value for name, row in rows.items()} == {
                name: known.state for name, known in self.model.passes.items()
            }
        self.model.passes = {}
        for name, row in rows.items():
            consist = row.consist or {}
            wheelsets = [each["wheelset"] for each in consist.get("wheelsets", [])] or None
            recordings = recordings_of(session, row)
            calibrated = [each.sensor for each in recordings if each.calibration_id]
            self.model.passes[name] = KnownPass(
                train=row.train,
                consist=wheelsets,
                named_coming=consist.get("named") == Named.COMING,
                state=row.state.value,
                calibrated=tuple(calibrated),
                job=row.job_id,
                axles=row.axles,
                ended=row.ended_by is not None,
                blank=not any(each.recorded for each in recordings),
            )

    def read_sessions(self, session, *, foreseen):
        rows = {row.id: row for row in session.query(CalibrationSession)}
        if foreseen:
            assert {name: (row.state.value, row.pictures) for name, row in rows.items()} == {
                name: (known.state, known.pictures) for name, known in self.model.sessions.items()
            }
        self.model.sessions = {
            name: KnownSession(
                row.sensor, row.target, row.state.value, row.pictures, row.ended_by is not None
            )
            for name, row in rows.items()
        }

    def read_orders(self, session):
        self.model.calibrations, self.model.recalibrations = (
            {row.id: KnownOrder(row.sensor, row.job_id, row.state.value) for row in rows}
            for rows in (session.query(Calibration), session.query(Recalibration))
        )

    # -- the end ---------------------------------------------------------------------------------

    def all_ends_well(self):
        """A controller that behaves, after all that, brings everything to its end."""
        for capture in self.served.captures.values():
            capture.reachable = True
        for name, known in self.model.passes.items():
            if known.state in {"armed", "recording"}:
                self.ask_plainly(
                    self.post(f"/v1/passes/{name}/finish", {"axles": 0}, None),
                    lambda name=name: self.model.finish_pass(name, 0, None),
                )
        for name, known in self.model.sessions.items():
            if known.state in {"armed", "open"}:
                self.ask_plainly(
                    self.post(f"/v1/calibration-sessions/{name}/finish", None, None),
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


def work(served, job_id, *, well):
    """Do what the worker does with a job, but its mathematics."""
    now = served.station.now()
    with served.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is JobState.QUEUED:
            start(job, at=now)
        end(job, JobState.DONE if well else JobState.FAILED, at=now)
        if job.kind == JobKind.MEASURE:
            row = the(session, Pass, job.subject)
            cut = any(each.recovered for each in recordings_of(session, row))
            ended = PassState.RECOVERED if cut else PassState.DONE
            row.state = ended if well else PassState.FAILED
        elif job.kind == JobKind.CALIBRATE:
            calibration = the(session, Calibration, job.subject)
            calibration.state = CalibrationState.READY if well else CalibrationState.FAILED
            calibration.document = "{}" if well else None
        else:
            recalibration = the(session, Recalibration, job.subject)
            recalibration.state = RecalibrationState.KEPT if well else RecalibrationState.FAILED
            recalibration.version += 1


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
