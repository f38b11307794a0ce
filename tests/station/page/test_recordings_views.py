"""Shows what the recordings page makes of the store's rows; how that looks the walks show."""

import math
from datetime import UTC, date, datetime
from zoneinfo import ZoneInfo

import pytest

from measure import Quantity
from station.errors import InputUnusable
from station.page.recordings.comparison import compared, profiles_compared
from station.page.recordings.condition import Condition, condition_of
from station.page.recordings.recording_view import spread
from station.page.recordings.search import Search
from station.page.recordings.wheels import Standing, own_readings, standing_of
from station.store import Measurement, Recording
from station.store.lists import Span
from station.store.recordings_found import RecordingKind

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
GOOD = {"closed_at": NOON, "recorded": 8, "lost": 0, "complete": True, "recovered": False}


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({}, Condition.WHOLE),
        ({"sha256": "00", "complete": None}, Condition.UPLOADED),
        ({"sha256": "00", "lost": 1}, Condition.LOSSY),
        ({"lost": 1}, Condition.LOSSY),
        ({"refused": 1}, Condition.LOSSY),
        ({"complete": False}, Condition.LOSSY),
        ({"recovered": True, "complete": False}, Condition.CUT_SHORT),
        ({"recorded": 0, "lost": 8}, Condition.EMPTY),
        ({"closed_at": None, "recorded": None}, Condition.RUNNING),
        ({"deleted_at": NOON, "lost": 1}, Condition.DELETED),
    ],
)
def test_condition_of_a_recording_is_its_worst(values, expected):
    assert condition_of(Recording(id="r", **GOOD | values)) is expected


def test_thumbnails_are_spread_from_the_first_frame_to_the_last():
    found = spread(32_000, 16)
    assert (found[0], found[-1], len(set(found))) == (1, 32_000, 16)
    assert list(found) == sorted(found)


def test_days_of_the_search_are_those_of_the_stations_zone():
    search = Search(first=date(2026, 7, 1), last=date(2026, 7, 1), kind=RecordingKind.LOSSY)
    wanted = search.wanted(ZoneInfo("Europe/Berlin"))
    assert wanted.kind is RecordingKind.LOSSY
    begin = datetime(2026, 6, 30, 22, tzinfo=UTC)
    assert wanted.span == Span(begin, datetime(2026, 7, 1, 22, tzinfo=UTC))


def test_search_stands_in_the_address_without_its_empty_fields():
    search = Search(name="<b> &", sensor="left")
    assert search.older("2026 r") == "/recordings?before=2026+r&name=%3Cb%3E+%26&sensor=left"
    assert search.asks
    assert not Search(before="2026 r").asks


def test_last_day_before_the_first_is_refused():
    with pytest.raises(InputUnusable, match="the last day comes before the first"):
        Search(first=date(2026, 7, 2), last=date(2026, 7, 1)).wanted(None)


def measurement(number, frame, *, frames=(), calibration="c1", reference="S1002", **readings):
    wheel = {"frames": list(frames)}
    for name, value in readings.items():
        wheel[name] = None if value is None else reading(*value)
    return Measurement(
        id=number,
        recording_id="r",
        frame=frame,
        calibration_id=calibration,
        reference=reference,
        sensor="left",
        wheel=wheel,
    )


def reading(value, u95, alarm="none"):
    return {"value": value, "u95": u95, "status": "ok", "alarm": alarm}


def test_own_readings_are_by_the_calibration_it_was_recorded_under_else_the_first():
    rows = [
        measurement(1, 9, calibration="other"),
        measurement(2, 9),
        measurement(3, 4),
        measurement(4, 4, reference="LMA"),
    ]
    recording = Recording(id="r", calibration_id="c1")
    assert [row.id for row in own_readings(recording, rows)] == [3, 2]
    assert [row.id for row in own_readings(Recording(id="r"), rows)] == [1]
    assert own_readings(recording, []) == []


def test_what_a_rig_saw_of_a_recording_counts_before_what_was_measured_of_it_alone():
    alone, once_more = measurement(3, 4), measurement(4, 4)
    seen, against_another, later = (measurement(n, n) for n in (1, 2, 5))
    for row in (seen, against_another, later):
        row.rig_calibration_id = "g1"
    against_another.reference, once_more.rig_calibration_id = "LMA", "g2"
    recording = Recording(id="r", calibration_id="c1", rig_calibration_id="g1")
    together = [seen, against_another]
    assert own_readings(recording, [alone, once_more], together) == [seen]
    assert own_readings(recording, [alone, once_more, later], together) == [later, seen]
    assert own_readings(recording, [alone, once_more]) == [alone]


@pytest.mark.parametrize(
    ("alarms", "reason", "expected"),
    [
        (["none", "unknown"], None, Standing.FINE),
        (["none", "warning"], None, Standing.WARNING),
        (["alarm", "warning"], None, Standing.ALARM),
        (["alarm"], "too dark", Standing.UNMEASURED),
    ],
)
def test_standing_of_a_wheel_is_its_worst_alarm(alarms, reason, expected):
    names = [quantity.value for quantity in Quantity]
    told = {name: reading(1.0, 0.1, alarm) for name, alarm in zip(names, alarms, strict=False)}
    assert standing_of(told | {"reason": reason}) is expected


def test_readings_of_one_wheel_are_paired_by_a_frame_they_share():
    before = [measurement(1, 4, frames=[3, 4]), measurement(2, 9, frames=[9])]
    after = [measurement(3, 3, frames=[3, 4]), measurement(4, 20)]
    pairs = [
        (pair.before and pair.before.id, pair.after and pair.after.id)
        for pair in compared(before, after)
    ]
    assert pairs == [(1, 3), (2, None), (None, 4)]


def test_readings_of_a_rig_are_paired_by_the_time_when_the_wheel_went_by():
    def seen(number, recording_id, time):
        row = measurement(number, 7 * number)
        row.recording_id, row.wheel["time"] = recording_id, time
        return row

    before = [
        seen(1, "other", "2026-07-01T12:00:00.000000Z"),
        seen(2, "other", "2026-07-01T12:00:00.060000Z"),
    ]
    after = [seen(3, "r", "2026-07-01T12:00:00.041000Z"), seen(4, "r", None)]
    pairs = {
        (pair.before and pair.before.id, pair.after and pair.after.id)
        for pair in compared(before, after)
    }
    assert pairs == {(1, None), (2, 3), (None, 4)}


def test_readings_agree_where_they_differ_by_no_more_than_both_uncertainties_together():
    before = measurement(1, 4, flange_height=(30.0, 0.3), diameter=(900.0, 0.3), hollow_depth=None)
    after = measurement(2, 4, flange_height=(30.5, 0.4), diameter=(900.51, 0.4))
    (pair,) = compared([before], [after])
    height, diameter = pair.differences
    assert height.quantity is Quantity.FLANGE_HEIGHT
    assert height.by == pytest.approx(0.5)
    assert height.u95 == pytest.approx(0.5)
    assert (height.agrees, diameter.agrees) == (True, False)


def test_what_one_reading_lacks_is_neither_agreed_nor_different():
    before = measurement(1, 4, flange_height=(30.0, 0.3))
    after = measurement(2, 4, flange_height=(None, None))
    (row,) = compared([before], [after])[0].differences
    assert (row.by, row.u95, row.agrees) == (None, None, None)


def test_heights_are_not_compared_where_the_profile_is_upright():
    heights = {"d_mm": [0.0, 1.0, 2.0, 3.0, 4.0], "h_mm": [-30.0, 0.0, 0.5, 1.0, 1.5]}
    moved = {**heights, "h_mm": [-29.0, 0.1, 0.6, 1.1, 1.6]}
    for each in (heights, moved):
        each["sigma_mm"] = [0.03] * 5
    told = profiles_compared(heights, moved)
    found = dict(zip(told["d_mm"], told["difference_um"], strict=True))
    assert (found[0.5], found[3.0]) == (None, 100.0)
    point = {"d_mm": [1.0, 1.1], "h_mm": [0.0, 0.0], "sigma_mm": [0.03, 0.03]}
    assert profiles_compared(point, point) is None


def test_profiles_are_compared_on_one_grid_and_not_across_what_was_not_seen():
    before = {"d_mm": [0.0, 1.0, 2.0, 9.0, 10.0], "h_mm": [0.0, 1.0, 2.0, 9.0, 10.0]}
    after = {"d_mm": [10.0, 8.0, 6.0, 4.0, 2.0, 0.0], "h_mm": [10.1, 8.1, 6.1, 4.1, 2.1, 0.1]}
    for each in (before, after):
        each["sigma_mm"] = [0.03] * len(each["d_mm"])
    told = profiles_compared(before, after)
    rows = dict(zip(told["d_mm"], zip(*list(told.values())[1:], strict=True), strict=True))
    assert rows[1.0] == (1.0, 1.1, 100.0, pytest.approx(1960 * math.hypot(0.03, 0.03), abs=1e-3))
    assert rows[5.0] == (None, 5.1, None, None)
    assert profiles_compared(None, None) is None
    alone = profiles_compared(None, after)
    assert set(alone["difference_um"]) == {None}
    assert alone["after_mm"][0] == 0.1
