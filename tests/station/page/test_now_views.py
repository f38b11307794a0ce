"""What the page Now makes of a station's state; nothing here is drawn or asked over a network."""

import re
from datetime import UTC, datetime, timedelta

import pytest

from measure import Alarm, Quantity
from station.capture import CaptureState, CaptureStatus, Trigger
from station.page.now.calibrations import Figures, InForce, figures_in
from station.page.now.disk import DiskNow, picture_bytes
from station.page.now.passing import SHOWN, SensorCount, WheelNow, suggested_id
from station.page.now.sensors import Counters, Doing, doing_of
from station.page.now.troubles import troubles_now
from station.page.texts import Texts
from station.store import JobKind, Measurement, PassState, Recording
from station.watching import Severity, Trouble, TroubleKind

NOW = datetime(2026, 7, 1, 12, 0, tzinfo=UTC)
TEXTS = Texts.of()
READING = {"value": 6.2, "u95": 0.1, "status": "ok", "alarm": "alarm"}


def status(state=CaptureState.RECORDING, **told):
    return CaptureStatus(state, "left", **told)


@pytest.mark.parametrize(
    ("told", "doing"),
    [
        (status(CaptureState.IDLE), Doing.IDLE),
        (status(recorded=0), Doing.ARMED),
        (status(recorded=1), Doing.RECORDING),
        (status(CaptureState.BLIND, recorded=3), Doing.BLIND),
        (status(CaptureState.UNAVAILABLE), Doing.AWAY),
        (status(CaptureState.RECORDED), Doing.RECORDED),
        (None, Doing.SILENT),
    ],
)
def test_a_sensor_is_said_to_do_what_its_capture_process_does(told, doing):
    assert doing_of(told) is doing


def test_counters_are_of_the_recording_while_there_is_one_and_of_all_so_far_otherwise():
    totals = {"recorded": 90, "lost": 5, "refused": 1, "repeated": 0, "resent_packets": 7}
    running = Counters.of(status(recorded=4, lost=1, refused=2, totals=totals))
    assert (running.recorded, running.lost, running.refused) == (4, 1, 2)
    idle = Counters.of(status(CaptureState.IDLE, totals=totals))
    assert (idle.recorded, idle.lost, idle.resent_packets) == (90, 5, 7)


def test_the_figures_of_a_calibration_are_those_of_its_document():
    gates = '{"a": {"passed": true}, "b": {"passed": false}}'
    found = figures_in(f'{{"rms": {{"dots_px": 0.05, "stripe_px": 0.1}}, "quality": {gates}}}')
    assert found == Figures(dots_px=0.05, stripe_px=0.1, passed=1, gates=2)
    assert figures_in(None) == Figures()


@pytest.mark.parametrize(
    ("age", "said"),
    [
        (timedelta(hours=5, seconds=3), timedelta(hours=5, seconds=3)),
        (timedelta(days=41, seconds=9), timedelta(days=41)),
        (timedelta(seconds=-5), timedelta()),
    ],
)
def test_the_age_of_a_calibration_does_not_change_every_second_once_it_is_days_old(age, said):
    found = InForce("c", NOW - age, NOW, "somebody", True, Figures())
    assert found.age_s(NOW) == said.total_seconds()


def disk(**told):
    room = {"free_bytes": 900, "total_bytes": 1000, "kept_bytes": 100, "pass_bytes": 200}
    return DiskNow(**{**room, "per_day_bytes": 400.0, "makes_way": False, **told})


def test_the_disk_lasts_as_long_as_what_may_be_used_of_it_at_the_rate_of_the_last_days():
    assert disk().passes_left == 4
    assert disk().lasts_s == 2 * 86_400
    assert disk(kept_bytes=1000).passes_left == 0
    assert disk(per_day_bytes=0.0).lasts_s is None
    assert not disk().outlasts
    assert disk(per_day_bytes=0.01).outlasts


@pytest.mark.parametrize("camera", [{}, {"width": "1024"}, {"width": "x", "height": "2"}])
def test_a_camera_that_does_not_say_its_size_has_none(camera):
    assert picture_bytes(status(camera=camera)) is None
    assert picture_bytes(None) is None


def test_what_a_sensor_has_of_a_pass_is_told_by_its_capture_while_that_records_it():
    row = Recording(sensor="left", pass_id="p", closed_at=None, expected=None)
    mine = status(session_id="p", recorded=4, lost=1, refused=1, silent_s=2.0)
    assert SensorCount.of(row, mine) == SensorCount("left", Doing.RECORDING, 4, 2, None, 2.0)
    other = SensorCount.of(row, status(session_id="another", recorded=9))
    assert (other.recorded, other.lost) == (None, None)
    assert SensorCount.of(row, None).doing is Doing.SILENT


def test_what_a_sensor_had_of_a_pass_is_told_by_its_recording_once_that_is_closed():
    row = Recording(sensor="left", pass_id="p", closed_at=NOW, recorded=7, lost=1, refused=2)
    assert SensorCount.of(row, status(recorded=99)) == SensorCount("left", None, 7, 3, None)


def test_a_wheel_is_shown_by_what_is_read_first_or_by_why_nothing_could_be_read():
    wheel = {"tread_wear": READING, "hollow_depth": READING}
    found = WheelNow.of(Measurement(id=1, sensor="left", frame=2, wheel=wheel))
    assert tuple(found.readings) == SHOWN
    assert found.readings[Quantity.TREAD_WEAR].alarm is Alarm.ALARM
    assert found.readings[Quantity.FLANGE_HEIGHT].value is None
    nothing = Measurement(id=2, sensor="left", frame=3, wheel={"reason": "too dark"})
    assert WheelNow.of(nothing).reason == "too dark"


def test_the_name_suggested_for_a_pass_is_one_that_the_station_takes():
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}", suggested_id(NOW))


@pytest.mark.parametrize("kind", TroubleKind)
def test_every_trouble_says_what_to_do_and_none_sends_a_person_to_the_api(kind):
    [found] = troubles_now([Trouble(kind, "worker", "what was seen", NOW)])
    cure = TEXTS.say(found.cure_key) if found.cure_key else found.told.cure
    assert cure
    assert "/v1/" not in cure


def test_whatever_a_state_is_called_there_is_a_text_for_it():
    wanted = [f"now.doing.{each}" for each in Doing]
    wanted += [f"now.doing_hint.{each}" for each in Doing]
    wanted += [f"now.trigger.{each}" for each in Trigger]
    wanted += [f"now.severity.{each}" for each in Severity]
    wanted += [f"now.pass_state.{each}" for each in PassState]
    wanted += [f"now.job_kind.{each}" for each in JobKind]
    wanted += [f"now.level.{each}" for each in Alarm]
    wanted += [f"now.quantity.{each}" for each in SHOWN]
    assert [each for each in wanted if each not in TEXTS] == []
    assert set(SHOWN) <= set(Quantity)
