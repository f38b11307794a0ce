"""Shows the passes of a rig measured again after one of its sensors was recalibrated, and that what
a recalibration needs stays on the disk until then.  The mathematics is a double."""

from datetime import timedelta

import pytest
from worker_double import WHEELS, SlowMathematics, a_calibration_document

from station.operations import bring_into_force, utc_now
from station.settings import RecalibrationSettings
from station.store import (
    STATION,
    Calibration,
    CalibrationSession,
    CalibrationState,
    Job,
    JobState,
    Pass,
    Recalibration,
    RecalibrationState,
    Recording,
    SessionState,
    activate,
    end,
    start,
    the,
)
from station.store.disposal import disposable_recordings
from station.store.lists import measurements_page
from station.store.measured import wheels_of
from station.worker.context import WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step
from station.worker.measuring_again import (
    begin_measuring_again,
    conclude_measuring_again,
    measure_recording_again,
)

BOTH = ("inner", "outer")
AGAIN = RecalibrationSettings(policy={"drifted": "ask", "measure_again": True})
PICTURES = "session.s1.outer"


class Mathematics(SlowMathematics):
    """Keeps by which calibrations it was told to measure."""

    def measure_rig(self, sources, rig, *, calibrations, **rest):
        self.measured_by = {each.sensor: each.software for each in calibrations}
        return super().measure_rig(sources, rig, **rest)


@pytest.fixture
def mathematics(tmp_path):
    return Mathematics(tmp_path / "trace", step_s=0.0)


@pytest.fixture
def context(ground, mathematics):
    settings = ground.settings.model_copy(update={"recalibration": AGAIN})
    return WorkContext(settings, ground.store, ground.layout, mathematics.parts)


@pytest.fixture
def asking(ground, context):
    """A measured pass of a rig, and a recalibration of one of its sensors that found a drift."""
    before = utc_now() - timedelta(hours=1)
    with ground.store.change() as session:
        present = the(session, Calibration, "of-outer")
        activate(session, present, sensor="outer", seen=None, by=STATION, at=before)
    job = ground.order_measuring("p1", sensors=BOTH, rig=ground.bring_rig_into_force())
    steps = begin_measuring(context, job)
    conclude_measuring(context, job, [measure_step(context, job, s, place=0, of=1) for s in steps])
    with ground.store.change() as session:
        session.add(
            CalibrationSession(
                id="s1", state=SessionState.RECORDED, sensor="outer", target="dots:7x8:12",
                pictures=12, opened_at=before,
            )
        )  # fmt: skip
        session.flush()
        session.add(
            Recording(
                id=PICTURES, sensor="outer", session_id="s1", path="s1.mcap", opened_at=before,
                closed_at=before, recorded=12,
            )
        )  # fmt: skip
        newer = a_calibration_document("outer").model_copy(update={"software": "newer"})
        session.add(
            Calibration(
                id="r1", state=CalibrationState.READY, sensor="outer", target="dots:7x8:12",
                method="joint", recording_ids={"recordings": [PICTURES], "laser_off": []},
                created_at=utc_now(), job_id="j1", document=newer.model_dump_json(), passed=True,
            )
        )  # fmt: skip
        session.flush()
        session.add(
            Recalibration(
                id="r1", state=RecalibrationState.ASKING, sensor="outer", ordered_at=utc_now(),
                ordered_by="test", job_id="j1", ended_at=utc_now(), outcome="drifted", alarm=True,
                taken={"recordings": [PICTURES], "target": "dots:7x8:12", "piece": []},
                calibration_id="r1", present_id="of-outer", present_version=1, findings={},
                version=1,
            )
        )  # fmt: skip
    return "r1"


def accept(ground, context):
    """Bring the new calibration into force; return the job that measures again."""
    with ground.store.change() as session:
        row = the(session, Recalibration, "r1")
        job = bring_into_force(session, context.settings, row, by=STATION, at=utc_now())
        row.state = RecalibrationState.ACTIVATED
    return job.id


def measure_again(context, job):
    steps = begin_measuring_again(context, job)
    return steps, [measure_recording_again(context, job, s, place=0, of=1) for s in steps]


def wheels(ground):
    with ground.store.look() as session:
        return measurements_page(session, limit=100, pass_id="p1").rows


def disposable(ground):
    with ground.store.look() as session:
        return {row.id for row in disposable_recordings(session)}


def test_wheels_of_the_rig_are_measured_with_the_new_calibration_beside_the_old_ones(
    ground, context, mathematics, asking
):
    job = accept(ground, context)
    for _ in range(2):  # a second time, as after a crash, adds nothing
        steps, results = measure_again(context, job)
    conclude_measuring_again(context, job, results)
    assert steps == ["pass.p1.outer"]
    assert mathematics.measured_by == {"inner": "treadline 0", "outer": "newer"}
    old, new = wheels(ground)[:WHEELS], wheels(ground)[WHEELS:]
    assert {each.calibration_id for each in old} == {"of-inner"}
    assert len(new) == WHEELS
    assert {(each.calibration_id, each.rig_calibration_id) for each in new} == {("r1", "of-wheel")}
    assert {(each.recording_id, each.sensor) for each in new} == {("pass.p1.outer", "wheel")}
    # Its frame is of the other sensor, as the wheel says.
    assert [each.wheel["frame"] for each in new] == [1, 2, 3, 4]
    with ground.store.look() as session:
        assert list(wheels_of(session, the(session, Pass, "p1"))) != new
        assert the(session, Job, job).state is JobState.DONE


def test_without_what_another_sensor_recorded_nothing_is_measured_and_that_is_said(
    ground, context, asking
):
    job = accept(ground, context)
    with ground.store.change() as session:
        the(session, Recording, "pass.p1.inner").deleted_at = utc_now()
    _, results = measure_again(context, job)
    conclude_measuring_again(context, job, results)
    assert len(wheels(ground)) == WHEELS
    with ground.store.look() as session:
        row = the(session, Job, job)
    assert row.state is JobState.FAILED
    assert "what sensor inner recorded has been deleted" in row.error


def test_pictures_stay_while_a_person_is_asked_about_them(ground, asking):
    passes = {"pass.p1.inner", "pass.p1.outer"}
    assert disposable(ground) == passes
    with ground.store.change() as session:
        the(session, Recalibration, "r1").state = RecalibrationState.REFUSED
    assert disposable(ground) == passes | {PICTURES}


def test_passes_stay_until_they_have_been_measured_again(ground, context, asking):
    job = accept(ground, context)
    assert disposable(ground) == set()
    with ground.store.change() as session:
        start(the(session, Job, job), at=utc_now())
        end(the(session, Job, job), JobState.DONE, at=utc_now())
    assert disposable(ground) == {"pass.p1.inner", "pass.p1.outer"}
