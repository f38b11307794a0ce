"""The worker keeps the disk within its limits beside its jobs; which files go is not shown here."""

import errno
import os
import threading

import pytest

import station.worker.process as process
from station.settings import StorageSettings
from station.store import Measurement, Pass, PassState, Recording, the


class NoJobs:
    """The jobs' engine, with nothing to do; it lets the worker go round three times."""

    def __init__(self, _context):
        self.rounds = 0

    def launch(self):
        pass

    def take_in(self):
        self.rounds += 1
        if self.rounds == 3:
            self.stop_signal.set()

    def stop(self, _patience_s):
        pass


@pytest.fixture
def run(ground, monkeypatch):
    """Run the worker three times round with a limit of age that everything is beyond."""

    def run_worker():
        NoJobs.stop_signal = threading.Event()
        monkeypatch.setattr(process, "Workflows", NoJobs)
        monkeypatch.setattr(process, "_SWEEP_S", 0.01)
        storage = StorageSettings(keep_days=1e-9)
        settings = ground.settings.model_copy(update={"storage": storage})
        process.work(settings, None, stop=NoJobs.stop_signal)

    return run_worker


def test_measured_recording_beyond_the_limit_is_gone_once_the_worker_has_gone_round(ground, run):
    ground.order_measuring("p1", sensors=["left"])
    with ground.store.change() as session:
        the(session, Pass, "p1").state = PassState.DONE
        row = the(session, Recording, "pass.p1.left")
        session.add(
            Measurement(
                recording_id=row.id, frame=1, calibration_id=row.calibration_id, sensor="left",
                pass_id="p1", reference="S1002", software="none", measured_at=row.opened_at,
                wheel={},
            )
        )  # fmt: skip
    file = ground.layout.root / "left.mcap"
    file.write_bytes(b"frames")
    run()
    assert not file.exists()
    with ground.store.look() as session:
        assert the(session, Recording, "pass.p1.left").deleted_at is not None


def test_disk_is_looked_at_now_and_then_not_every_round(run, monkeypatch):
    looks = []
    monkeypatch.setattr(process, "tidy", lambda *_: looks.append(1))
    run()
    assert looks == [1]


def test_disk_that_refuses_does_not_end_the_worker(run, monkeypatch):
    def refuse(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(process, "tidy", refuse)
    run()
