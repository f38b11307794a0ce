"""Shows that jobs survive the death of the worker: real processes, a real engine, kill -9.  The
mathematics is slow and plain, so that the moment of death can be chosen."""

import multiprocessing
import time

import pytest
from worker_double import WHEELS, run_double

from station.errors import StateConflict
from station.operations import cancel_job
from station.operations.collaborators import Station
from station.store import Actor, Calibration, Job, JobKind, Pass, the
from station.store.lists import measurements_page
from station.worker import WorkerQueue, held, is_held

PATIENCE_S = 60.0


class Workers:
    """Starts worker processes on a ground and reads what they did."""

    def __init__(self, ground, trace):
        self._ground = ground
        self._trace = trace
        self.process = None

    def start(self, step_s=0.02, stays_at=()):
        self.process = multiprocessing.get_context("spawn").Process(
            target=run_double, args=(self._ground.settings, self._trace, step_s, stays_at)
        )
        self.process.start()

    def kill(self):
        self.process.kill()
        self.process.join()

    @property
    def did(self):
        return self._trace.read_text().splitlines() if self._trace.exists() else []

    def wait(self, reached, what):
        deadline = time.monotonic() + PATIENCE_S
        while not reached():
            assert self.process.exitcode is None, f"{what}: the worker ended"
            assert time.monotonic() < deadline, f"{what}: {self.did}"
            time.sleep(0.02)

    def wait_for_end(self, job_id):
        self.wait(lambda: self.job(job_id).ended_at is not None, f"end of {job_id}")

    def job(self, job_id):
        with self._ground.store.look() as session:
            return the(session, Job, job_id)


@pytest.fixture
def workers(ground, tmp_path):
    workers = Workers(ground, tmp_path / "trace")
    yield workers
    if workers.process is not None:
        workers.kill()


def test_a_worker_killed_in_the_middle_of_two_jobs_ends_each_once(ground, workers):
    rig = ground.bring_rig_into_force()
    measuring = ground.order_measuring("p1", sensors=("inner", "outer", "right"), rig=rig)
    ground.take_off_rig("p1", "right")
    solving = ground.order_calibration("c1")
    half = {"end measure rig wheel", "begin measure right", "begin calibrate left"}
    workers.start(stays_at=[line for line in half if line.startswith("begin")])
    workers.wait(lambda: half <= set(workers.did), "the recording after the rig's begun")
    assert is_held(ground.layout.worker_lock)
    workers.kill()
    assert "end measure right" not in workers.did
    assert workers.job(measuring).state == "running"
    assert not is_held(ground.layout.worker_lock)

    workers.start()
    workers.wait_for_end(measuring)
    workers.wait_for_end(solving)
    # The step that was done stays done; the one that was cut is done again.
    assert workers.did.count("begin measure rig wheel inner outer") == 1
    assert workers.did.count("begin measure right") == 2
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state == "done"
        assert the(session, Calibration, "c1").state == "ready"
        wheels = measurements_page(session, limit=100).rows
    assert len(wheels) == 2 * WHEELS
    assert len({(w.recording_id, w.frame) for w in wheels}) == 2 * WHEELS
    assert [w.sensor for w in wheels] == ["wheel"] * WHEELS + ["right"] * WHEELS


def test_a_worker_takes_up_what_it_is_told_what_it_was_not_and_what_was_given_up(ground, workers):
    station = Station(
        settings=ground.settings,
        store=ground.store,
        layout=ground.layout,
        captures={},
        jobs=WorkerQueue(ground.layout.jobs_url),
        salvage=lambda _: None,
    )
    # The worker's database does not exist yet: not being heard is no error.
    untold = ground.order_calibration("untold")
    station.jobs.submit(JobKind.CALIBRATE, untold)
    workers.start(step_s=0.05)
    workers.wait_for_end(untold)
    assert workers.job(untold).state == "done"

    told = ground.order_calibration("told")
    for _ in range(3):
        station.jobs.submit(JobKind.CALIBRATE, told)
    workers.wait_for_end(told)
    assert workers.job(told).state == "done"
    assert len(workers.did) == 4

    slow = ground.order_measuring("p1")
    station.jobs.submit(JobKind.MEASURE, slow)
    workers.wait(lambda: "begin measure left" in workers.did, "measuring begun")
    cancel_job(station, slow, by=Actor("test"))
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state == "recorded"

    # The engine gives up a job that waits behind another; the store must not wait for ever.
    before, given_up = ground.order_measuring("p2"), ground.order_measuring("p3")
    station.jobs.submit(JobKind.MEASURE, before)
    station.jobs.submit(JobKind.MEASURE, given_up)
    station.jobs.cancel(given_up)
    workers.wait_for_end(given_up)
    workers.wait_for_end(before)
    assert workers.job(given_up).error == "the worker ended it (cancelled); order it again"
    assert workers.job(before).state == "done"
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state == "recorded"


def test_a_second_worker_on_the_same_data_is_refused(tmp_path):
    lock = tmp_path / "worker.lock"
    assert not is_held(lock)
    naps = []
    with held(lock, "a worker"):
        assert is_held(lock)
        with pytest.raises(StateConflict, match="a worker runs already"):
            held(lock, "a worker", sleep=naps.append).__enter__()
    assert not is_held(lock)
    assert sum(naps) >= 1.0
