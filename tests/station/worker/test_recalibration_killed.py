"""Shows that a recalibration survives the death of the worker: a real engine, kill -9 in the middle
of its solving, of its deciding and of measuring again."""

import multiprocessing
import threading
import time
from datetime import timedelta

import pytest
from recalibration_ground import PointsMathematics, Shop
from sensor_points import turned
from sqlalchemy import select

from station.scenes import paper_sensor
from station.serve import log_as
from station.settings import RecalibrationSettings
from station.store import Activation, Calibration, Job, Recalibration, the
from station.store.lists import measurements_page
from station.worker.process import work

PATIENCE_S = 60.0
BY_ITSELF = {"drifted": "activate", "confirmations": 1, "measure_again": True}


def run(settings, trace, stays_at):
    log_as("worker")
    mathematics = PointsMathematics(trace, step_s=0.0, stays_at=stays_at)
    work(settings, mathematics.parts, stop=threading.Event())


class Worker:
    def __init__(self, shop):
        self._shop = shop
        self.process = None

    def start(self, stays_at=()):
        self.process = multiprocessing.get_context("spawn").Process(
            target=run, args=(self._shop.station_settings, self._shop.trace, stays_at)
        )
        self.process.start()

    def kill(self):
        self.process.kill()
        self.process.join()

    @property
    def did(self):
        trace = self._shop.trace
        return trace.read_text().splitlines() if trace.exists() else []

    def wait(self, reached, what):
        deadline = time.monotonic() + PATIENCE_S
        while not reached():
            assert self.process.exitcode is None, f"{what}: the worker ended"
            assert time.monotonic() < deadline, f"{what}: {self.did}"
            time.sleep(0.02)

    def ended(self, job_id):
        with self._shop.store.look() as session:
            job = session.get(Job, job_id)
        return job is not None and job.ended_at is not None


@pytest.fixture
def shop(ground, tmp_path, rng):
    shop = Shop(ground, tmp_path / "trace", rng)
    shop.activate_first()
    shop.settings = RecalibrationSettings(policy=BY_ITSELF)
    return shop


@pytest.fixture
def worker(shop):
    worker = Worker(shop)
    yield worker
    if worker.process is not None:
        worker.kill()


def all_of(shop, table):
    with shop.store.look() as session:
        return session.scalars(select(table)).all()


def test_worker_killed_while_solving_and_while_measuring_again_ends_all_of_it_once(shop, worker):
    shop.passed("p")
    shop.session(sensor=turned(paper_sensor(), 1e-3))
    job = shop.order()
    worker.start(stays_at=["begin calibrate left"])
    worker.wait(lambda: "begin calibrate left" in worker.did, "solving begun")
    worker.kill()
    assert "end calibrate left" not in worker.did
    assert shop.found().state == "running"

    worker.start(stays_at=["begin measure p"])
    worker.wait(lambda: "begin measure p" in worker.did, "measuring again begun")
    assert worker.ended(job)
    worker.kill()
    assert "end measure p" not in worker.did

    worker.start()
    worker.wait(lambda: worker.ended("again-r1"), "measured again")
    # What was solved stays solved; what was cut is done again.
    assert worker.did.count("begin calibrate left") == 2
    assert worker.did.count("end calibrate left") == 1
    assert worker.did.count("end measure p") == 1
    row = shop.found()
    assert (row.state, row.outcome) == ("activated", "drifted")
    activations = [each for each in all_of(shop, Activation) if each.sensor == "left"]
    assert [(each.version, each.calibration_id) for each in activations] == [
        (1, "first"),
        (2, "r1"),
    ]
    assert len([each for each in all_of(shop, Calibration) if each.id == "r1"]) == 1
    with shop.store.look() as session:
        assert the(session, Job, "again-r1").state == "done"
        wheels = measurements_page(session, limit=100).rows
    assert {each.calibration_id for each in wheels} == {"r1"}
    assert len(wheels) == len({each.frame for each in wheels}) == 4


def test_worker_orders_what_its_schedule_owes(shop, worker):
    # In force for a year: whatever the clock says, one is owed, however many were missed.
    with shop.store.change() as session:
        for each in session.scalars(select(Activation)):
            each.activated_at -= timedelta(days=366)
    due = shop.now.time().replace(hour=0, minute=0, second=0, microsecond=0)
    shop.settings = RecalibrationSettings(at=due)
    worker.start()
    worker.wait(lambda: all_of(shop, Recalibration), "ordered")
    (row,) = all_of(shop, Recalibration)
    worker.wait(lambda: worker.ended(row.job_id), "done")
    (row,) = all_of(shop, Recalibration)
    assert (row.sensor, row.ordered_by, row.state) == ("left", "schedule", "kept")
    assert row.due_at.time() == due
