"""Shows what the steps of the jobs leave in the store, called directly.  That they survive a killed
worker is shown with the real engine."""

import pytest
from worker_double import WHEELS, SlowMathematics

from station.operations import cancel_job
from station.operations.collaborators import Station
from station.store import Actor, AxleWheel, Calibration, CalibrationPoints, Job, Pass, the
from station.store.lists import measurements_page
from station.store.measured import axles_of, wheels_of
from station.worker.calibrating import calibrate
from station.worker.context import WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step


@pytest.fixture
def context(ground, tmp_path):
    mathematics = SlowMathematics(tmp_path / "trace", step_s=0.0)
    return WorkContext(ground.settings, ground.store, ground.layout, mathematics.parts)


def measure_all(context, job_id):
    steps = begin_measuring(context, job_id)
    results = [
        measure_step(context, job_id, each, place=place, of=len(steps))
        for place, each in enumerate(steps)
    ]
    conclude_measuring(context, job_id, results)


def found(ground, table, row_id):
    with ground.store.look() as session:
        return the(session, table, row_id)


def cancel(ground, job_id):
    class Deaf:
        def cancel(self, _job_id): ...

    station = Station(ground.settings, ground.store, ground.layout, {}, Deaf(), lambda _: None)
    cancel_job(station, job_id, by=Actor("test"))


def test_a_measured_pass_is_done_and_names_frame_calibration_and_software(ground, context):
    job = ground.order_measuring("p1")
    measure_all(context, job)
    row = found(ground, Pass, "p1")
    assert (row.state, row.reason) == ("done", None)
    assert (found(ground, Job, job).state, found(ground, Job, job).progress) == ("done", 1.0)
    with ground.store.look() as session:
        wheels = wheels_of(session, row)
    assert [(w.sensor, w.frame, w.calibration_id) for w in wheels] == [
        (sensor, frame, f"of-{sensor}")
        for sensor in ("left", "right")
        for frame in range(1, WHEELS + 1)
    ]
    assert {(w.software, w.reference, w.recording_id[:8]) for w in wheels} == {
        ("treadline 0", "S1002", "pass.p1.")
    }
    assert {w.regime for w in wheels} == {"practice"}


def test_a_step_done_again_after_a_crash_adds_nothing(ground, context):
    job = ground.order_measuring("p1")
    steps = begin_measuring(context, job)
    for _ in range(3):
        measure_step(context, job, steps[0], place=0, of=2)
    measure_all(context, job)
    measure_all(context, job)
    with ground.store.look() as session:
        assert len(measurements_page(session, limit=100).rows) == 2 * WHEELS


def test_a_pass_cut_by_a_crash_ends_recovered(ground, context):
    measure_all(context, ground.order_measuring("p1", recovered=True))
    assert found(ground, Pass, "p1").state == "recovered"


def test_one_recording_that_fails_does_not_take_the_other_with_it(ground, context):
    job = ground.order_measuring("p1", names={"right": "unreadable"})
    measure_all(context, job)
    row = found(ground, Pass, "p1")
    assert row.state == "done"
    # What nobody foresaw is for the log, not for the controller.
    assert row.reason == (
        "pass.p1.right: internal error (RuntimeError); the worker's log has it under job job-p1"
    )
    with ground.store.look() as session:
        assert {w.sensor for w in wheels_of(session, row)} == {"left"}
        why = {each.reason for each in axles_of(session, "p1") if each.side == "right"}
    assert why == {"sensor right: no wheel of its recording was measured"}


def test_a_pass_of_which_nothing_can_be_measured_fails_with_the_reason(ground, context):
    job = ground.order_measuring("p1", sensors=["left"], names={"left": "unreadable"})
    measure_all(context, job)
    assert found(ground, Pass, "p1").state == "failed"
    assert "internal error" in found(ground, Job, job).error


def test_readings_stand_where_no_axles_can_be_made_of_them(ground, context, monkeypatch):
    def fail(session, row, _settings):
        session.add(AxleWheel(pass_id=row.id))  # half of it is in the transaction by then
        raise ZeroDivisionError

    monkeypatch.setattr("station.worker.measuring.keep_axles", fail)
    measure_all(context, ground.order_measuring("p1"))
    row = found(ground, Pass, "p1")
    assert row.state == "done"
    assert row.reason.startswith("no axles: internal error (ZeroDivisionError)")
    with ground.store.look() as session:
        assert len(wheels_of(session, row)) == 2 * WHEELS
        assert axles_of(session, "p1") == []


def test_a_cancelled_job_keeps_nothing_it_was_at(ground, context):
    job = ground.order_measuring("p1")
    steps = begin_measuring(context, job)
    cancel(ground, job)
    result = measure_step(context, job, steps[0], place=0, of=2)
    assert result["refused"] == "cancelled"
    conclude_measuring(context, job, [result])
    assert found(ground, Pass, "p1").state == "recorded"
    assert begin_measuring(context, job) == []
    with ground.store.look() as session:
        assert measurements_page(session, limit=10).rows == []


def test_a_job_cancelled_after_its_last_word_keeps_nothing_either(ground, tmp_path):
    """Between the last progress and the result nobody looks whether the job was cancelled."""

    class LateCancel(SlowMathematics):
        def _work(self, progress):
            cancel(ground, job)

    late = LateCancel(tmp_path / "trace")
    context = WorkContext(ground.settings, ground.store, ground.layout, late.parts)
    job = ground.order_measuring("p1", sensors=["left"])
    measure_all(context, job)
    assert found(ground, Pass, "p1").state == "recorded"
    with ground.store.look() as session:
        assert measurements_page(session, limit=10).rows == []

    job = ground.order_calibration("c1")
    calibrate(context, job)
    assert found(ground, Calibration, "c1").reason == "cancelled"
    with ground.store.look() as session:
        assert session.get(CalibrationPoints, "c1") is None


def test_a_solved_calibration_is_ready_with_file_and_points(ground, context):
    job = ground.order_calibration("c1")
    calibrate(context, job)
    row = found(ground, Calibration, "c1")
    assert (row.state, row.passed) == ("ready", True)
    assert '"treadline-calibration"' in row.document
    with ground.store.look() as session:
        assert session.get(CalibrationPoints, "c1").csv == "image,kind\n"
    calibrate(context, job)
    assert found(ground, Job, job).state == "done"


def test_a_refused_calibration_has_failed_with_the_line_of_the_refusal(ground, context):
    job = ground.order_calibration("c1", target="dots:2x3:12")
    calibrate(context, job)
    row = found(ground, Calibration, "c1")
    assert (row.state, row.reason) == (
        "failed",
        "1 view; allowed: 3 and more; take more pictures",
    )
    assert found(ground, Job, job).error == row.reason


def test_a_calibration_cancelled_before_it_began_is_not_solved(ground, context, tmp_path):
    job = ground.order_calibration("c1")
    cancel(ground, job)
    calibrate(context, job)
    assert found(ground, Calibration, "c1").reason == "cancelled"
    assert not (tmp_path / "trace").exists()
