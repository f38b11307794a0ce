"""Shows what the worker orders by the station's schedule, with a clock of the test's."""

from datetime import datetime, time, timedelta
from zoneinfo import ZoneInfo

import pytest
from recalibration_ground import Shop
from sqlalchemy import select

from station.settings import RecalibrationSettings
from station.store import STATION, Calibration, Recalibration, activate, the
from station.worker.scheduling import order_what_is_owed

BERLIN = ZoneInfo("Europe/Berlin")


@pytest.fixture
def shop(ground, tmp_path, rng):
    shop = Shop(ground, tmp_path / "trace", rng, now=datetime(2026, 3, 27, 12, tzinfo=BERLIN))
    shop.settings = RecalibrationSettings(at=time(2, 30), zone="Europe/Berlin")
    with shop.store.change() as session:
        first = the(session, Calibration, "of-left")
        activate(session, first, sensor="left", seen=None, by=STATION, at=shop.now)
    return shop


def ordered(shop):
    return [(row.sensor, row.due_at) for row in order_what_is_owed(shop.context)]


def finish_all(shop):
    with shop.store.change() as session:
        for row in session.scalars(select(Recalibration)):
            row.state = "kept"


def test_a_night_has_one_and_only_sensors_with_a_calibration_have_it(shop):
    assert ordered(shop) == []
    shop.now = datetime(2026, 3, 28, 2, 30, tzinfo=BERLIN)
    assert ordered(shop) == [("left", shop.now)]
    assert ordered(shop) == []
    finish_all(shop)
    assert ordered(shop) == []


def test_station_that_was_off_for_nights_makes_up_for_them_by_one(shop):
    shop.now = datetime(2026, 4, 2, 9, tzinfo=BERLIN)
    assert ordered(shop) == [("left", datetime(2026, 4, 2, 2, 30, tzinfo=BERLIN))]
    finish_all(shop)
    shop.now += timedelta(hours=1)
    assert ordered(shop) == []


def test_night_of_the_change_of_clocks_has_one_too(shop):
    due = []
    while shop.now < datetime(2026, 3, 30, 12, tzinfo=BERLIN):
        due += [at.astimezone(BERLIN).strftime("%d %H:%M") for _, at in ordered(shop)]
        finish_all(shop)
        shop.now += timedelta(minutes=10)
    assert due == ["28 02:30", "29 03:30", "30 02:30"]


def test_one_that_still_runs_is_not_joined_by_another(shop):
    shop.now = datetime(2026, 3, 28, 3, tzinfo=BERLIN)
    assert len(ordered(shop)) == 1
    shop.now += timedelta(days=1)
    assert ordered(shop) == []


def test_without_a_time_nothing_is_ordered(shop):
    shop.settings = RecalibrationSettings()
    shop.now += timedelta(days=3)
    assert ordered(shop) == []
