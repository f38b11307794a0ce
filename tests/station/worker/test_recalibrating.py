"""Shows what a recalibration leaves in the store: real calibrations from points of known truth,
each step called directly.  That it survives a killed worker is shown with the real engine."""

import json
from datetime import timedelta

import pytest
from recalibration_ground import Shop
from sensor_points import turned
from worker_double import WHEELS

from station.operations import Station, answer_recalibration, cancel_job
from station.scenes import paper_sensor
from station.settings import RecalibrationSettings
from station.store import (
    STATION,
    Calibration,
    Job,
    JobKind,
    Measurement,
    Pass,
    PassState,
    activate,
    active,
    the,
)
from station.store.lists import measurements_page
from station.store.recalibrations import alarm_of
from station.worker.measuring_again import (
    begin_measuring_again,
    conclude_measuring_again,
    measure_recording_again,
)
from station.worker.recalibrating import STEPS, conclude_recalibration, do_step, recalibrate
from station.worker.recalibrating import take_up_recalibration as take_up

# Ten times what the comparison of sheets expects of a sensor at rest, about 0.01 mm.
DRIFT_RAD = 1e-3
BY_ITSELF = {"policy": {"drifted": "activate", "measure_again": True}}


@pytest.fixture
def shop(ground, tmp_path, rng):
    shop = Shop(ground, tmp_path / "trace", rng)
    shop.activate_first()
    return shop


def in_force(shop):
    with shop.store.look() as session:
        return active(session, "left")


def station_of(shop):
    class Deaf:
        def cancel(self, _job_id): ...

        def submit(self, _kind, _job_id): ...

    return Station(
        shop.station_settings, shop.store, shop.ground.layout, {}, Deaf(), lambda _: None,
        now=lambda: shop.now,
    )  # fmt: skip


def test_sensor_at_rest_keeps_its_calibration_and_says_why(shop):
    shop.session()
    row = shop.recalibrate()
    assert (row.state, row.outcome, row.alarm, row.reason) == ("kept", "consistent", False, None)
    assert row.calibration_id == "r1"
    assert in_force(shop).calibration_id == "first"
    assert "is expected of their uncertainties" in row.reasons["reasons"][0]
    # At rest the RMS difference is about what is expected: beyond 3.5 times once in 2000 nights.
    assert row.figures["sheet_rms_mm"] < 3.5 * row.figures["sheet_expected_mm"]
    with shop.store.look() as session:
        assert the(session, Job, row.job_id).state == "done"


def test_turned_sheet_is_found_and_a_person_asked(shop):
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    row = shop.recalibrate()
    assert (row.state, row.outcome, row.action, row.alarm) == ("asking", "drifted", "ask", True)
    assert row.figures["sheet_largest_mm"] > 0.1
    with shop.store.look() as session:
        assert alarm_of(session, "left").id == "r1"


def test_answer_of_a_person_brings_it_into_force_once_and_ends_the_alarm(shop):
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    seen = shop.recalibrate().version
    answered = answer_recalibration(
        station_of(shop), "r1", bring=True, why="bracket was hit", seen=seen, by=STATION
    )
    assert (answered.state, answered.answer) == ("activated", "bracket was hit")
    assert (in_force(shop).calibration_id, in_force(shop).version) == ("r1", 2)
    assert answered.activated_version == 2
    with shop.store.look() as session:
        assert alarm_of(session, "left") is None


def test_drift_is_followed_by_itself_only_when_a_second_night_agrees(shop):
    shop.settings = RecalibrationSettings(**BY_ITSELF)
    drifted = turned(paper_sensor(), DRIFT_RAD)
    shop.session(sensor=drifted)
    first = shop.recalibrate("n1")
    assert (first.outcome, first.state) == ("drifted", "kept")
    assert "found 1 times of the 2 that confirm it" in first.reasons["reasons"]
    shop.session(sensor=drifted)
    second = shop.recalibrate("n2")
    assert (second.outcome, second.state) == ("drifted", "activated")
    assert in_force(shop).calibration_id == "n2"
    assert in_force(shop).activated_by == "recalibration n2"
    shop.session(sensor=drifted)
    third = shop.recalibrate("n3")
    assert third.outcome in {"consistent", "improved"}


def test_second_drift_that_disagrees_with_the_first_confirms_nothing(shop):
    shop.settings = RecalibrationSettings(**BY_ITSELF)
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    shop.recalibrate("n1")
    shop.session(sensor=turned(paper_sensor(), -DRIFT_RAD))
    row = shop.recalibrate("n2")
    assert (row.outcome, row.state, row.findings["confirmed"]) == ("drifted", "kept", 0)
    # Nor does the first confirm a third: nights count in a row.
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    row = shop.recalibrate("n3")
    assert (row.outcome, row.state, row.findings["confirmed"]) == ("drifted", "kept", 0)


def test_drift_that_a_person_refused_neither_stands_nor_confirms_another(shop):
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    seen = shop.recalibrate("n1").version
    answer_recalibration(
        station_of(shop), "n1", bring=False, why="bent board", seen=seen, by=STATION
    )
    idle = shop.recalibrate("idle")
    assert (idle.outcome, idle.alarm) == ("nothing_new", False)
    shop.settings = RecalibrationSettings(**BY_ITSELF)
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    assert shop.recalibrate("n2").findings["confirmed"] == 0


def test_passes_since_the_last_good_check_are_measured_again_beside_what_was_measured(shop):
    shop.settings = RecalibrationSettings(**BY_ITSELF)
    shop.passed("before")
    shop.session()
    assert shop.recalibrate("good").outcome == "consistent"
    shop.passed("after")
    old = Measurement(
        recording_id="pass.after.left", frame=1, calibration_id="first", sensor="left",
        pass_id="after", reference="S1002", software="-", measured_at=shop.now, wheel={},
    )  # fmt: skip
    with shop.store.change() as session:
        session.add(old)
    for night in ("n1", "n2"):
        shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
        row = shop.recalibrate(night)
    job = row.measuring_job_id
    for _ in range(2):  # a second time, as after a crash, adds nothing
        steps = begin_measuring_again(shop.context, job)
        results = [
            measure_recording_again(shop.context, job, step, place=0, of=1) for step in steps
        ]
    conclude_measuring_again(shop.context, job, results)
    assert steps == ["pass.after.left"]
    with shop.store.look() as session:
        wheels = measurements_page(session, limit=100, pass_id="after").rows
        assert (the(session, Job, job).kind, the(session, Job, job).state) == (
            JobKind.MEASURE_AGAIN,
            "done",
        )
    assert [each.calibration_id for each in wheels] == ["first"] + ["n2"] * WHEELS


def test_pictures_are_taken_once_and_without_new_ones_nothing_changes(shop):
    shop.session()
    assert shop.recalibrate("n1").outcome == "consistent"
    row = shop.recalibrate("n2")
    assert (row.outcome, row.state, row.calibration_id) == ("nothing_new", "kept", None)


def test_old_pictures_and_those_of_another_target_are_left(shop):
    old = shop.session()
    shop.now += timedelta(hours=40)
    other = shop.session(target="chessboard:5x6:12")
    new = shop.session()
    row = shop.recalibrate()
    assert row.taken["recordings"] == [new]
    assert old not in row.taken["recordings"]
    assert other not in row.taken["recordings"]


def test_too_few_poses_are_doubtful_and_no_calibration_is_lost(shop):
    shop.session(poses=4)
    row = shop.recalibrate()
    assert (row.outcome, row.state) == ("doubtful", "kept")
    assert any("4 poses; at least 6 are needed" in each for each in row.reasons["reasons"])


def test_pictures_that_cannot_be_solved_are_a_finding_not_a_failure(shop):
    shop.session(poses=1)
    row = shop.recalibrate()
    assert (row.outcome, row.state, row.calibration_id) == ("doubtful", "kept", None)


def test_calibration_of_a_turned_camera_sees_nothing_in_common_and_is_doubtful(shop):
    shop.settings = RecalibrationSettings(sensors={"left": {"camera": "solve"}})
    with shop.store.change() as session:
        first = the(session, Calibration, "first")
        document = json.loads(first.document)
        # A sheet behind the camera, which no pixel meets.
        document["plane"] = {"a": 0.0, "b": 0.0, "c": 1.0, "d": 100.0}
        first.document = json.dumps(document)
    shop.session(poses=25)
    row = shop.recalibrate()
    assert (row.outcome, row.state) == ("doubtful", "kept")
    json.dumps([row.findings, row.figures], allow_nan=False)


def test_first_calibration_of_a_sensor_is_asked_for(ground, tmp_path, rng):
    shop = Shop(ground, tmp_path / "trace", rng)
    shop.session(poses=25)
    row = shop.recalibrate()
    # From these points alone the sheet may be known too badly for its gate.
    assert (row.outcome, row.state) in {("first", "asking"), ("doubtful", "kept")}
    assert in_force(shop) is None


def test_later_recalibration_ends_the_question_of_an_earlier_one(shop):
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    assert shop.recalibrate("n1").state == "asking"
    # A night without pictures knows nothing better: the question and the alarm stand.
    idle = shop.recalibrate("idle")
    assert (idle.state, idle.alarm, shop.found("n1").state) == ("kept", True, "asking")
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    assert shop.recalibrate("n2").state == "asking"
    assert shop.found("n1").state == "superseded"


def test_every_step_twice_is_as_good_as_once(shop):
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    job = shop.order()
    for _ in range(2):
        take_up(shop.context, job, sleep=lambda _: None)
        for place in range(len(STEPS)):
            do_step(shop.context, job, place)
            do_step(shop.context, job, place)
    for _ in range(3):
        conclude_recalibration(shop.context, job)
    row = shop.found()
    assert (row.state, row.calibration_id) == ("asking", "r1")
    assert shop.trace.read_text().count("begin calibrate") == 1


def test_it_waits_for_a_pass_to_end_and_does_not_solve_before(shop):
    shop.session()
    with shop.store.change() as session:
        session.add(Pass(id="p", state=PassState.RECORDING, opened_at=shop.now))
    naps = []

    def sleep(seconds):
        naps.append(seconds)
        assert not shop.trace.exists()
        if len(naps) == 3:
            with shop.store.change() as session:
                the(session, Pass, "p").state = PassState.DONE

    recalibrate(shop.context, shop.order(), sleep=sleep)
    assert len(naps) == 3
    assert shop.found().outcome == "consistent"


def test_patience_that_is_out_ends_it_with_the_reason(shop):
    shop.session()
    with shop.store.change() as session:
        session.add(Pass(id="p", state=PassState.RECORDING, opened_at=shop.now))

    naps = []

    def sleep(seconds):
        naps.append(seconds)
        shop.now += timedelta(hours=1)

    recalibrate(shop.context, shop.order(), sleep=sleep)
    row = shop.found()
    # After the fourth hour more than three have gone.
    assert len(naps) == 4
    assert row.state == "failed"
    assert row.reason.startswith("given up after 3 h, as pass p is recording")


def test_calibration_that_comes_into_force_meanwhile_stays(shop):
    shop.settings = RecalibrationSettings(policy={"drifted": "activate", "confirmations": 1})
    shop.session(sensor=turned(paper_sensor(), DRIFT_RAD))
    job = shop.order()
    take_up(shop.context, job, sleep=lambda _: None)
    for place in range(len(STEPS)):
        do_step(shop.context, job, place)
    with shop.store.change() as session:
        first = the(session, Calibration, "first")
        activate(session, first, sensor="left", seen=1, by=STATION, at=shop.now)
    conclude_recalibration(shop.context, job)
    row = shop.found()
    assert row.state == "failed"
    assert "keeps what came into force while it was recalibrated" in row.reason
    assert (in_force(shop).calibration_id, in_force(shop).version) == ("first", 2)


def test_cancelled_recalibration_has_failed_and_is_not_gone_on_with(shop):
    shop.session()
    job = shop.order()
    take_up(shop.context, job, sleep=lambda _: None)
    cancel_job(station_of(shop), job, by=STATION)
    do_step(shop.context, job, 0)
    conclude_recalibration(shop.context, job)
    assert (shop.found().state, shop.found().reason) == ("failed", "cancelled")
