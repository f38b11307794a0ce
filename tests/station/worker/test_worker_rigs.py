"""Shows what the jobs of rigs leave in the store: one wheel from all sensors of a rig, once."""

from dataclasses import replace

import numpy as np
import pytest
from rig_recordings import RIG_WHEEL, RIGHT, calibration_of, record_rig, true_rig
from worker_double import WHEELS, SlowMathematics

from station.operations import cancel_job
from station.operations.collaborators import Station
from station.pipeline import (
    calibrate_rig_sources,
    calibrate_sources,
    measure_rig,
    measure_sources,
)
from station.settings import TrackSettings
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    Job,
    Pass,
    PassState,
    RigCalibration,
    RigCalibrationPoints,
    the,
)
from station.store.disposal import measured_recordings
from station.store.lists import measurements_page
from station.store.measured import axles_of, wheels_of
from station.worker.calibrating_rig import calibrate_rig
from station.worker.context import Mathematics, WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step

BOTH = ("inner", "outer")
REAL = Mathematics(calibrate_sources, measure_sources, calibrate_rig_sources, measure_rig)
TRACK = TrackSettings(distance_mm=1500.0, sigma_distance_mm=0.05, sigma_turn_rad=1e-4)


@pytest.fixture
def trace(tmp_path):
    return tmp_path / "trace"


@pytest.fixture
def context(ground, trace):
    mathematics = SlowMathematics(trace, step_s=0.0)
    return WorkContext(ground.settings, ground.store, ground.layout, mathematics.parts)


def measure_all(context, job_id):
    steps = begin_measuring(context, job_id)
    results = [
        measure_step(context, job_id, each, place=place, of=len(steps))
        for place, each in enumerate(steps)
    ]
    conclude_measuring(context, job_id, results)
    return steps


def found(ground, table, row_id):
    with ground.store.look() as session:
        return the(session, table, row_id)


def test_recordings_of_a_rig_are_one_step_and_each_wheel_is_one_row(ground, context, trace):
    rig = ground.bring_rig_into_force()
    job = ground.order_measuring("p1", sensors=(*BOTH, "right"), rig=rig)
    ground.take_off_rig("p1", "right")
    assert measure_all(context, job) == ["rig:of-wheel", "pass.p1.right"]
    row = found(ground, Pass, "p1")
    assert (row.state, row.reason) == ("done", None)
    with ground.store.look() as session:
        wheels = wheels_of(session, row)
        sides = {each.side: each for each in axles_of(session, "p1")}
    assert [(w.sensor, w.frame, w.rig_calibration_id) for w in wheels] == [
        *(("right", frame, None) for frame in range(1, WHEELS + 1)),
        *(("wheel", frame, rig) for frame in range(1, WHEELS + 1)),
    ]
    assert "begin measure rig wheel inner outer" in trace.read_text()
    # Left and right wheel of an axle stand beside each other: a rig is one looker at its side.
    assert None not in {sides["left"].measurement_id, sides["right"].measurement_id}


def test_an_axle_that_a_rig_did_not_see_was_missed_by_the_rig_not_by_each_of_its_sensors(
    ground, context
):
    job = ground.order_measuring("p1", sensors=BOTH, rig=ground.bring_rig_into_force())
    with ground.store.change() as session:
        the(session, Pass, "p1").axles = WHEELS + 1
    measure_all(context, job)
    with ground.store.look() as session:
        left = [each for each in axles_of(session, "p1") if each.side == "left"]
    missed = "sensor wheel: no frame of this axle"
    assert [each.reason for each in left] == [*[None] * WHEELS, missed]


def test_a_rigs_step_done_again_after_a_crash_adds_nothing(ground, context):
    job = ground.order_measuring("p1", sensors=BOTH, rig=ground.bring_rig_into_force())
    (step,) = begin_measuring(context, job)
    for _ in range(3):
        measure_step(context, job, step, place=0, of=1)
    measure_all(context, job)
    with ground.store.look() as session:
        assert len(measurements_page(session, limit=100).rows) == WHEELS


def test_a_sensor_that_recorded_nothing_leaves_the_wheel_to_the_other_and_is_named(ground, context):
    job = ground.order_measuring(
        "p1", sensors=BOTH, rig=ground.bring_rig_into_force(), recorded={"outer": 0}
    )
    measure_all(context, job)
    row = found(ground, Pass, "p1")
    assert row.reason == "pass.p1.outer: no frame was recorded"
    with ground.store.look() as session:
        wheel = wheels_of(session, row)[0]
    assert wheel.wheel["sensors"] == ["inner"]
    assert wheel.wheel["quality"]["by_sensor"] == {"outer": "no frame was recorded"}


def test_without_a_rig_in_force_sensors_are_measured_one_by_one_and_the_pass_says_so(
    ground, context
):
    job = ground.order_measuring("p1", sensors=BOTH)
    assert measure_all(context, job) == ["pass.p1.inner", "pass.p1.outer"]
    assert found(ground, Pass, "p1").reason == (
        "rig wheel: no calibration was active, its sensors were measured one by one"
    )


def test_both_recordings_of_a_measured_rig_have_served_their_purpose(ground, context):
    """Its wheels are kept beside one of the recordings."""
    job = ground.order_measuring("p1", sensors=BOTH, rig=ground.bring_rig_into_force())
    measure_all(context, job)
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state is PassState.DONE
        assert {each.sensor for each in measured_recordings(session)} == set(BOTH)


def test_a_calibrated_rig_is_ready_with_its_file(ground, context):
    job = ground.order_rig_calibration("r1")
    calibrate_rig(context, job)
    row = found(ground, RigCalibration, "r1")
    assert (row.state, row.passed, found(ground, Job, job).state) == ("ready", True, "done")
    assert '"anchor":"inner"' in row.document
    for sensor in BOTH:
        with ground.store.look() as session:
            assert session.get(RigCalibrationPoints, ("r1", sensor)).csv == "image,kind\n"


def test_a_rig_that_cannot_be_calibrated_fails_with_the_reason(ground, context, monkeypatch):
    taken_out = ground.settings.model_copy(update={"rigs": ()})
    job = ground.order_rig_calibration("r1")
    calibrate_rig(WorkContext(taken_out, *_rest(context)), job)
    row = found(ground, RigCalibration, "r1")
    assert (row.state, row.document) == ("failed", None)
    assert row.reason == "rig 'wheel' was taken out of the settings; order it anew"


def test_a_cancelled_calibration_of_a_rig_has_failed(ground):
    class Deaf:
        def cancel(self, _job_id): ...

    job = ground.order_rig_calibration("r1")
    cancel_job(
        Station(ground.settings, ground.store, ground.layout, {}, Deaf(), lambda _: None),
        job,
        by=Actor("test"),
    )
    assert found(ground, RigCalibration, "r1").reason == "cancelled"


def test_real_recordings_of_both_sensors_become_wheels_of_the_rig(ground, context, rig_shots):
    record_rig(ground.layout.root, [rig_shots[:1], rig_shots[:1]], lost=[("outer", 2)])
    bring_true_rig_into_force(ground, context)
    job = ground.order_measuring("p1", sensors=BOTH, rig="true")
    measure_all(replace(context, mathematics=REAL), job)
    row = found(ground, Pass, "p1")
    assert (row.state, row.reason) == ("done", None)
    with ground.store.look() as session:
        both, one = [each.wheel for each in wheels_of(session, row)]
        places = axles_of(session, "p1")
    assert (both["sensors"], one["sensors"]) == (["inner", "outer"], ["inner"])
    assert both["flange_thickness_10"]["status"] == "ok"
    assert both["quality"]["by_sensor"]["outer"]["points"] > 0
    assert "recalibrated" not in both["quality"]
    assert [(each.number, each.reason is None) for each in places if each.side == "left"] == [
        (1, True),
        (2, True),
    ]


def test_a_rig_on_the_left_and_a_sensor_on_the_right_tell_the_distance_of_their_axle(
    ground, context, rig_shots
):
    """The sensor's mounting is the same as a rig of one."""
    record_rig(ground.layout.root, [rig_shots])
    record_rig(ground.layout.root, [right_views()], sensors=["right"])
    rig = bring_true_rig_into_force(ground, context)
    with ground.store.change() as session:
        of_right = calibration_of("right-inner", truth=RIGHT)
        the(session, Calibration, "of-right").document = of_right.model_copy(
            update={"sensor": "right"}
        ).model_dump_json()
    job = ground.order_measuring("p1", sensors=(*BOTH, "right"), rig=rig)
    ground.take_off_rig("p1", "right")
    settings = ground.settings.model_copy(update={"track": TRACK})
    measure_all(replace(context, mathematics=REAL, settings=settings), job)
    with ground.store.look() as session:
        (left, right) = axles_of(session, "p1")
    assert left.back_to_back == right.back_to_back
    found = left.back_to_back
    assert (found["status"], found["pairs"], found["alarm"]) == ("ok", 2, "none")
    # 1500 mm from tape circle to tape circle, flange backs 70 mm inside of each; three of the
    # standard deviations that it tells itself.
    assert found["value"] == pytest.approx(1360.0, abs=3.0 * found["u95"] / 1.96)
    assert found["u95"] < 1.0


def right_views():
    scenes = [
        RIGHT.shot(RIG_WHEEL, axle_offset_mm=offset_mm, seed=9)["right-inner"]
        for offset_mm in (-20.0, 10.0)
    ]
    rng = np.random.default_rng(5)
    return [{"right": scene.render(rng)} for scene in scenes]


def bring_true_rig_into_force(ground, context):
    with ground.store.change() as session:
        for sensor in BOTH:
            the(session, Calibration, f"of-{sensor}").document = calibration_of(
                sensor
            ).model_dump_json()
        session.add(
            RigCalibration(
                id="true",
                state=CalibrationState.READY,
                rig="wheel",
                created_at=context.now(),
                document=true_rig().model_dump_json(),
            )
        )
    return "true"


def _rest(context):
    return context.store, context.layout, context.mathematics
