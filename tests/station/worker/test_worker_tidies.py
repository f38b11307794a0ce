"""The worker keeps the disk within its limits by jobs that it orders itself, and that survive its
death; which recordings go is shown with the storage."""

import errno
import multiprocessing
import os
import threading
import time
from datetime import timedelta

import numpy as np
import pytest
from worker_double import run_double

import station.worker.process as process
from station.operations import utc_now
from station.recording import RecordingWriter, is_compact
from station.settings import StorageSettings
from station.store import (
    Job,
    JobKind,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    end,
    the,
    unfinished_jobs,
)
from station.store.lists import audit_page
from station.worker.context import WorkContext
from station.worker.housekeeping import (
    begin_compacting,
    compact_one,
    conclude_compacting,
    delete_what_is_due,
    order_housekeeping,
)

ALL_GO = StorageSettings(keep_days=1e-9)
COMPACT = StorageSettings(compact_after_days=0.0)


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
    """Run the worker three times round."""

    def run_worker():
        NoJobs.stop_signal = threading.Event()
        monkeypatch.setattr(process, "Workflows", NoJobs)
        monkeypatch.setattr(process, "_SWEEP_S", 0.01)
        process.work(with_storage(ground, ALL_GO), None, stop=NoJobs.stop_signal)

    return run_worker


def with_storage(ground, storage):
    return ground.settings.model_copy(update={"storage": storage})


def context_of(ground, storage, now=utc_now):
    return WorkContext(with_storage(ground, storage), ground.store, ground.layout, None, now=now)


def a_measured_pass(ground, name, *, state=PassState.DONE):
    """A pass of one sensor, measured, with a recording that is worth compacting."""
    job_id = ground.order_measuring(name, sensors=["left"], names={"left": f"recordings/{name}"})
    with ground.store.change() as session:
        the(session, Pass, name).state = state
        end(the(session, Job, job_id), JobState.CANCELLED, at=utc_now())
        row = the(session, Recording, f"pass.{name}.left")
        session.add(
            Measurement(
                recording_id=row.id, frame=1, calibration_id=row.calibration_id, sensor="left",
                pass_id=name, reference="S1002", software="none", measured_at=row.opened_at,
                wheel={},
            )
        )  # fmt: skip
    path = ground.layout.root / "recordings" / f"{name}.mcap"
    path.parent.mkdir(exist_ok=True)
    picture = np.zeros((48, 64), np.uint8).data.cast("B")
    with RecordingWriter(path) as writer:
        for number in range(1, 9):
            writer.write_frame("left", number, number, number, picture, 64, 48)
    return path


def recording_of(ground, name):
    with ground.store.look() as session:
        return the(session, Recording, f"pass.{name}.left")


def deletions_in_the_trail(ground):
    with ground.store.look() as session:
        entries = audit_page(session, limit=100).rows
    return sorted(each.subject for each in entries if each.action == "delete")


def test_what_is_to_make_way_is_ordered_once_and_deleted_by_the_job(ground):
    file = a_measured_pass(ground, "p1")
    context = context_of(ground, ALL_GO)
    (job,) = order_housekeeping(context)
    assert order_housekeeping(context) == []
    assert job.kind == JobKind.RETENTION
    delete_what_is_due(context, job.id)
    assert not file.exists()
    assert recording_of(ground, "p1").deleted_at is not None
    assert deletions_in_the_trail(ground) == ["pass.p1.left"]
    assert order_housekeeping(context) == []
    with ground.store.look() as session:
        assert the(session, Job, job.id).state is JobState.DONE


def test_nothing_is_ordered_where_nothing_is_due(ground):
    a_measured_pass(ground, "p1")
    assert order_housekeeping(context_of(ground, StorageSettings())) == []
    assert order_housekeeping(context_of(ground, StorageSettings(keep_days=1.0))) == []
    assert order_housekeeping(context_of(ground, StorageSettings(compact_after_days=1.0))) == []


def test_a_failed_pass_keeps_its_recording_as_long_as_the_settings_say(ground):
    file = a_measured_pass(ground, "p1", state=PassState.FAILED)
    assert order_housekeeping(context_of(ground, ALL_GO)) == []
    storage = StorageSettings(keep_failed_days=30.0)
    assert order_housekeeping(context_of(ground, storage)) == []
    later = context_of(ground, storage, now=lambda: utc_now() + timedelta(days=31))
    (job,) = order_housekeeping(later)
    delete_what_is_due(later, job.id)
    assert not file.exists()
    assert "its pass failed" in recording_of(ground, "p1").deleted_why


def test_measured_recordings_are_compacted_once(ground):
    files = [a_measured_pass(ground, name) for name in ("p1", "p2")]
    context = context_of(ground, COMPACT)
    (job,) = order_housekeeping(context)
    names = begin_compacting(context, job.id)
    assert names == ["pass.p1.left", "pass.p2.left"]
    for place, name in enumerate(names):
        compact_one(context, job.id, name, place, len(names))
    conclude_compacting(context, job.id)
    assert all(is_compact(file) for file in files)
    assert recording_of(ground, "p2").compacted_at is not None
    assert order_housekeeping(context) == []


def test_a_damaged_recording_does_not_keep_others_from_being_compacted(ground):
    broken, sound = (a_measured_pass(ground, name) for name in ("p1", "p2"))
    broken.write_bytes(b"no recording")
    context = context_of(ground, COMPACT)
    (job,) = order_housekeeping(context)
    for place, name in enumerate(begin_compacting(context, job.id)):
        compact_one(context, job.id, name, place, 2)
    assert is_compact(sound)
    assert order_housekeeping(context) == []


def test_nothing_is_compacted_while_a_train_passes(ground):
    file = a_measured_pass(ground, "p1")
    context = context_of(ground, COMPACT)
    (job,) = order_housekeeping(context)
    names = begin_compacting(context, job.id)
    with ground.store.change() as session:
        session.add(Pass(id="p2", state=PassState.RECORDING, opened_at=utc_now()))
    compact_one(context, job.id, names[0], 0, 1)
    assert not is_compact(file)
    assert begin_compacting(context, job.id) == []
    assert recording_of(ground, "p1").compacted_at is None


def test_a_cancelled_deletion_ends_and_what_is_left_waits_for_the_next(ground):
    file = a_measured_pass(ground, "p1")
    context = context_of(ground, ALL_GO)
    (job,) = order_housekeeping(context)
    with ground.store.change() as session:
        end(the(session, Job, job.id), JobState.CANCELLED, at=utc_now())
    delete_what_is_due(context, job.id)
    assert file.exists()
    assert len(order_housekeeping(context)) == 1


def test_a_disk_that_refuses_fails_the_job_in_one_line(ground, monkeypatch):
    import station.worker.housekeeping as housekeeping  # noqa: PLC0415  beside its only use

    def refuse(*_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    a_measured_pass(ground, "p1")
    context = context_of(ground, ALL_GO)
    (job,) = order_housekeeping(context)
    monkeypatch.setattr(housekeeping, "tidy", refuse)
    delete_what_is_due(context, job.id)
    with ground.store.look() as session:
        assert "the disk refuses: [Errno 30] Read-only" in the(session, Job, job.id).error


def test_a_worker_killed_while_it_deletes_ends_the_job_after_the_next_start(ground, tmp_path):
    names = [f"p{n:02}" for n in range(12)]
    files = [a_measured_pass(ground, name) for name in names]
    settings = with_storage(ground, ALL_GO)

    def start():
        arguments = (settings, tmp_path / "trace", 0.0)
        worker = multiprocessing.get_context("spawn").Process(target=run_double, args=arguments)
        worker.start()
        return worker

    def wait(reached):
        deadline = time.monotonic() + 60.0
        while not reached():
            assert time.monotonic() < deadline
            time.sleep(0.002)

    worker = start()
    wait(lambda: not all(file.exists() for file in files))
    worker.kill()
    worker.join()
    worker = start()

    def ended():
        with ground.store.look() as session:
            idle = not unfinished_jobs(session)
        return idle and not any(file.exists() for file in files)

    wait(ended)
    worker.kill()
    worker.join()
    assert all(recording_of(ground, name).deleted_at is not None for name in names)
    assert deletions_in_the_trail(ground) == [f"pass.{name}.left" for name in names]


def test_disk_is_looked_at_now_and_then_not_every_round(run, monkeypatch):
    looks = []
    monkeypatch.setattr(process, "order_housekeeping", lambda *_: looks.append(1))
    run()
    assert looks == [1]


def test_disk_that_refuses_does_not_end_the_worker(run, monkeypatch):
    def refuse(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(process, "order_housekeeping", refuse)
    run()
