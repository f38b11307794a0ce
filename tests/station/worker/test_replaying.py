"""Shows what a replay leaves in the store: new readings beside the old, none twice, each named; and
that a killed worker goes on with it.  Which orders are refused is shown with the API."""

from dataclasses import replace

import pytest
from rig_recordings import record_rig
from test_worker_process import workers  # noqa: F401  a fixture
from test_worker_rigs import BOTH, REAL, bring_true_rig_into_force
from worker_double import WHEELS, SlowMathematics, a_calibration_document, a_rig_document

from station.operations import ReplayOrder, cancel_job, order_replay, replay_view, utc_now
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    Job,
    Pass,
    Recording,
    Replay,
    RigCalibration,
    the,
)
from station.store.disposal import disposable_recordings, recordings_in_use
from station.store.lists import measurements_page
from station.store.measured import wheels_of
from station.worker.context import WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step
from station.worker.replaying import begin_replay, conclude_replay, fail_replay, replay_step

PERSON = Actor("metrologist")


@pytest.fixture
def context(ground, tmp_path):
    mathematics = SlowMathematics(tmp_path / "trace", step_s=0.0)
    return WorkContext(ground.settings, ground.store, ground.layout, mathematics.parts)


def measure(context, job_id):
    steps = begin_measuring(context, job_id)
    results = [
        measure_step(context, job_id, each, place=place, of=len(steps))
        for place, each in enumerate(steps)
    ]
    conclude_measuring(context, job_id, results)


def add_calibration(ground, name, sensor="left"):
    with ground.store.change() as session:
        session.add(
            Calibration(
                id=name,
                state=CalibrationState.READY,
                sensor=sensor,
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=utc_now(),
                job_id=f"job-{name}",
                document=a_calibration_document(sensor).model_dump_json(),
            )
        )


def order(station, **what):
    return order_replay(station, ReplayOrder(**what), by=PERSON)


def replay(context, view):
    job = view.job.id
    for place in range(begin_replay(context, job)):
        replay_step(context, job, place)
    conclude_replay(context, job)
    with context.store.look() as session:
        return replay_view(session, the(session, Replay, view.row.id))


def rows(ground, **which):
    with ground.store.look() as session:
        return measurements_page(session, limit=1000, **which).rows


def wheels(ground, pass_id):
    with ground.store.look() as session:
        return wheels_of(session, the(session, Pass, pass_id))


def test_another_calibration_adds_readings_beside_those_of_the_pass(ground, context, station):
    measure(context, ground.order_measuring("p1"))
    before = [row.id for row in wheels(ground, "p1")]
    add_calibration(ground, "newer")
    done = replay(
        context, order(station, recordings=["pass.p1.left"], calibrations={"left": "newer"})
    )
    assert (done.job.state, done.job.error, done.measurements) == ("done", None, WHEELS)
    assert done.row.results == {"pass.p1.left": {"wheels": WHEELS, "added": WHEELS}}
    new = rows(ground, replay=done.row.id)
    assert {(row.calibration_id, row.recording_id, row.pass_id) for row in new} == {
        ("newer", "pass.p1.left", "p1")
    }
    assert [row.id for row in wheels(ground, "p1")] == before


def test_the_calibration_of_the_pass_adds_nothing_and_names_the_readings_of_the_pass(
    ground, context, station
):
    measure(context, ground.order_measuring("p1"))
    own = {"left": "of-left", "right": "of-right"}
    done = replay(context, order(station, pass_id="p1", calibrations=own))
    assert [each["added"] for each in done.row.results.values()] == [0, 0]
    assert done.measurements == 2 * WHEELS
    ids = [row.id for row in rows(ground, replay=done.row.id)]
    assert ids == [row.id for row in rows(ground)]


def test_another_reference_stands_behind_the_readings_of_the_pass(ground, context, station):
    measure(context, ground.order_measuring("p1"))
    own = {"left": "of-left", "right": "of-right"}
    done = replay(context, order(station, pass_id="p1", calibrations=own, reference="LMA"))
    assert done.measurements == 2 * WHEELS
    assert {row.reference for row in rows(ground, replay=done.row.id)} == {"LMA"}
    assert {row.reference for row in wheels(ground, "p1")} == {"S1002"}
    assert len(wheels(ground, "p1")) == 2 * WHEELS


def test_a_rig_measures_its_sensors_together_and_again_as_the_pass_did(ground, context, station):
    first = ground.bring_rig_into_force()
    measure(context, ground.order_measuring("p1", sensors=("inner", "outer"), rig=first))
    same = replay(context, order(station, pass_id="p1", rig_calibration=first))
    assert same.row.results == {"pass.p1.inner": {"wheels": WHEELS, "added": 0}}
    with ground.store.change() as session:
        document = a_rig_document("wheel", ["inner", "outer"]).model_dump_json()
        ready = CalibrationState.READY
        session.add(
            RigCalibration(
                id="later", state=ready, rig="wheel", created_at=utc_now(), document=document
            )
        )
    other = replay(context, order(station, pass_id="p1", rig_calibration="later"))
    assert other.row.results == {"pass.p1.inner": {"wheels": WHEELS, "added": WHEELS}}
    assert {row.rig_calibration_id for row in rows(ground, replay=other.row.id)} == {"later"}
    assert {row.rig_calibration_id for row in wheels(ground, "p1")} == {first}
    assert len(wheels(ground, "p1")) == WHEELS


def test_an_upload_of_a_pass_is_read_as_the_pass_was_bit_for_bit(
    ground, context, station, rig_shots
):
    """By the real mathematics, on a rig; and the pass itself gets nothing new."""
    record_rig(ground.layout.root, [rig_shots])
    rig = bring_true_rig_into_force(ground, context)
    real = replace(context, mathematics=REAL)
    measure(real, ground.order_measuring("p1", sensors=BOTH, rig=rig))
    with ground.store.change() as session:
        for sensor in BOTH:
            (ground.layout.root / f"copy-{sensor}.mcap").hardlink_to(
                ground.layout.root / f"{sensor}.mcap"
            )
            session.add(an_upload(sensor))
    same = {sensor: f"of-{sensor}" for sensor in BOTH}
    uploads = [f"upload.{sensor}" for sensor in BOTH]
    done = replay(real, order(station, recordings=uploads, rig_calibration=rig, calibrations=same))
    assert (done.job.error, done.row.results) == (
        None,
        {"upload.inner": {"wheels": 1, "added": 1}},
    )
    (own,), (copied,) = wheels(ground, "p1"), rows(ground, replay=done.row.id)
    assert own.wheel["flange_height"]["value"] is not None
    assert copied.wheel | {"source": ""} == own.wheel | {"source": ""}
    assert copied.pass_id is None
    again = replay(real, order(station, pass_id="p1", rig_calibration=rig))
    assert again.row.results == {"pass.p1.inner": {"wheels": 1, "added": 0}}


def an_upload(sensor):
    return Recording(
        id=f"upload.{sensor}",
        sensor=sensor,
        path=f"copy-{sensor}.mcap",
        opened_at=utc_now(),
        closed_at=utc_now(),
        recorded=2,
        recovered=False,
        sha256=sensor,
    )


def test_sensors_of_a_rig_measured_singly_do_not_stand_among_the_wheels_of_their_pass(
    ground, context, station
):
    rig = ground.bring_rig_into_force()
    measure(context, ground.order_measuring("p1", sensors=("inner", "outer"), rig=rig))
    own = {"inner": "of-inner", "outer": "of-outer"}
    done = replay(context, order(station, pass_id="p1", calibrations=own))
    assert [each["added"] for each in done.row.results.values()] == [WHEELS, WHEELS]
    assert {row.rig_calibration_id for row in wheels(ground, "p1")} == {rig}
    assert len(wheels(ground, "p1")) == WHEELS


def test_a_recording_that_cannot_be_measured_is_named_and_the_others_are(ground, context, station):
    ground.order_measuring("p1", names={"right": "unreadable"})
    own = {"left": "of-left", "right": "of-right"}
    done = replay(context, order(station, pass_id="p1", calibrations=own))
    assert (done.job.state, done.measurements) == ("done", WHEELS)
    assert done.job.error.startswith("pass.p1.right: internal error (RuntimeError)")


def test_a_replay_of_which_nothing_can_be_measured_has_failed(ground, context, station):
    ground.order_measuring("p1", names={"left": "unreadable"})
    view = order(station, recordings=["pass.p1.left"], calibrations={"left": "of-left"})
    assert replay(context, view).job.state == "failed"


def test_a_cancelled_replay_keeps_what_it_had_measured_and_adds_nothing(ground, context, station):
    ground.order_measuring("p1")
    own = {"left": "of-left", "right": "of-right"}
    view = order(station, pass_id="p1", calibrations=own)
    assert begin_replay(context, view.job.id) == 2
    replay_step(context, view.job.id, 0)
    cancel_job(station, view.job.id, by=PERSON)
    replay_step(context, view.job.id, 1)
    conclude_replay(context, view.job.id)
    fail_replay(context, view.job.id, "the engine gave it up")
    assert begin_replay(context, view.job.id) == 0
    with ground.store.look() as session:
        assert the(session, Job, view.job.id).state == "cancelled"
    assert {row.sensor for row in rows(ground, replay=view.row.id)} == {"left"}


def test_a_replay_cancelled_after_its_last_word_keeps_nothing_either(ground, station, tmp_path):
    """Between the last progress and the result nobody looks whether it was cancelled."""

    class LateCancel(SlowMathematics):
        def _work(self, progress):
            cancel_job(station, view.job.id, by=PERSON)

    late = LateCancel(tmp_path / "trace")
    context = WorkContext(ground.settings, ground.store, ground.layout, late.parts)
    ground.order_measuring("p1")
    view = order(station, recordings=["pass.p1.left"], calibrations={"left": "of-left"})
    assert replay(context, view).measurements == 0
    assert rows(ground) == []


def test_what_is_being_replayed_is_not_deleted_meanwhile(ground, context, station):
    measure(context, ground.order_measuring("p1"))
    view = order(station, recordings=["pass.p1.left"], calibrations={"left": "of-left"})
    with ground.store.look() as session:
        assert "pass.p1.left" in recordings_in_use(session)
        assert [row.id for row in disposable_recordings(session)] == ["pass.p1.right"]
    replay(context, view)
    with ground.store.look() as session:
        assert len(disposable_recordings(session)) == 2


def test_a_worker_killed_in_a_replay_goes_on_with_it_and_doubles_nothing(
    ground,
    station,
    workers,  # noqa: F811  the fixture
):
    measured = ground.order_measuring("p1")
    with ground.store.change() as session:
        session.delete(the(session, Job, measured))  # the replay alone is to be seen
    own = {"left": "of-left", "right": "of-right"}
    view = order(station, pass_id="p1", calibrations=own)
    workers.start(stays_at=["begin measure right"])
    workers.wait(lambda: "begin measure right" in workers.did, "the second recording begun")
    workers.kill()
    assert "end measure right" not in workers.did
    workers.start()
    workers.wait_for_end(view.job.id)
    assert workers.did.count("begin measure left") == 1
    assert workers.did.count("begin measure right") == 2
    assert workers.job(view.job.id).state == "done"
    found = rows(ground, replay=view.row.id)
    assert len(found) == len({(row.recording_id, row.frame) for row in found}) == 2 * WHEELS
