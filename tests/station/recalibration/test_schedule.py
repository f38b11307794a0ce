"""Shows when a recalibration is due, in the station's zone and across changes of its clocks."""

from datetime import UTC, datetime, time, timedelta
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.recalibration import Schedule, owed
from station.settings import RecalibrationSettings

BERLIN = ZoneInfo("Europe/Berlin")
NIGHTLY = Schedule(time(2, 30), frozenset(range(7)), BERLIN)
MOMENTS = st.datetimes(datetime(2025, 1, 1), datetime(2027, 12, 31), timezones=st.just(UTC))
SCHEDULES = st.builds(
    Schedule,
    st.times().map(lambda each: each.replace(microsecond=0)),
    st.frozensets(st.integers(0, 6), min_size=1),
    st.sampled_from([BERLIN, ZoneInfo("UTC"), ZoneInfo("Asia/Kolkata"), ZoneInfo("Pacific/Apia")]),
)


def local(*parts):
    return datetime(*parts, tzinfo=BERLIN)


def all_due(schedule, start, end):
    found, at = [], start
    while (at := schedule.next_due(at)) <= end:
        found.append(at)
    return found


def test_on_an_ordinary_day_it_is_due_at_its_time_of_the_local_day():
    noon = local(2026, 7, 1, 12)
    assert NIGHTLY.last_due(noon) == local(2026, 7, 1, 2, 30)
    assert NIGHTLY.next_due(noon) == local(2026, 7, 2, 2, 30)
    assert NIGHTLY.last_due(local(2026, 7, 1, 2, 29)) == local(2026, 6, 30, 2, 30)


def test_at_the_very_moment_it_is_due():
    at = local(2026, 7, 1, 2, 30)
    assert NIGHTLY.last_due(at) == at
    assert NIGHTLY.next_due(at) == local(2026, 7, 2, 2, 30)


def test_night_whose_clocks_leave_the_time_out_has_one_an_hour_later_by_the_new_clock():
    # 29 March 2026: 02:00 becomes 03:00, so that there is no 02:30.
    due = all_due(NIGHTLY, local(2026, 3, 28, 12), local(2026, 3, 30, 12))
    assert [each.astimezone(BERLIN).strftime("%d %H:%M") for each in due] == [
        "29 03:30",
        "30 02:30",
    ]


def test_night_whose_clocks_have_the_time_twice_has_one_the_first_time():
    # 25 October 2026: 03:00 becomes 02:00, so that 02:30 comes twice.
    due = all_due(NIGHTLY, local(2026, 10, 24, 12), local(2026, 10, 26, 12))
    assert due == [
        datetime(2026, 10, 25, 0, 30, tzinfo=UTC),
        datetime(2026, 10, 26, 1, 30, tzinfo=UTC),
    ]


def test_a_year_has_one_for_each_of_its_days():
    due = all_due(NIGHTLY, local(2025, 12, 31, 12), local(2026, 12, 31, 12))
    assert len(due) == 365
    assert len({each.astimezone(BERLIN).date() for each in due}) == 365


def test_only_its_days_of_the_week_count():
    sundays = RecalibrationSettings(at=time(2, 30), days=["sun"], zone="Europe/Berlin")
    schedule = Schedule.from_settings(sundays)
    assert schedule.last_due(local(2026, 7, 1, 12)) == local(2026, 6, 28, 2, 30)
    assert schedule.next_due(local(2026, 7, 1, 12)) == local(2026, 7, 5, 2, 30)


def test_without_a_time_there_is_no_schedule():
    assert Schedule.from_settings(RecalibrationSettings()) is None


@given(SCHEDULES, MOMENTS)
def test_last_and_next_stand_around_every_moment_with_nothing_between(schedule, now):
    last, following = schedule.last_due(now), schedule.next_due(now)
    assert last <= now < following
    assert schedule.next_due(last) == following
    # A week, and the hour or the day that a change of the clocks may add.
    assert following - last <= timedelta(days=8, hours=1)


def test_however_many_nights_were_missed_one_is_owed():
    since, now = local(2026, 7, 1, 2, 30), local(2026, 7, 9, 12)
    due = owed(NIGHTLY, since=since, now=now)
    assert due == local(2026, 7, 9, 2, 30)
    assert owed(NIGHTLY, since=due, now=now) is None


def test_a_calibration_activated_since_owes_none_of_the_nights_before_it():
    activated = local(2026, 7, 1, 11)
    assert owed(NIGHTLY, since=activated, now=local(2026, 7, 1, 12)) is None
    assert owed(NIGHTLY, since=activated, now=local(2026, 7, 2, 3)) == local(2026, 7, 2, 2, 30)


@pytest.mark.parametrize("weekdays", [frozenset(), frozenset({7})])
def test_schedule_without_a_day_of_the_week_is_refused(weekdays):
    with pytest.raises(ValueError, match="weekdays must be some of 0 to 6"):
        Schedule(time(2, 30), weekdays, BERLIN)
