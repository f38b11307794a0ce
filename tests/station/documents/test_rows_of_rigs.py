"""Shows what rows say of the sensors of a rig, and that of one by itself nothing is added."""

import json
from datetime import UTC, datetime

import numpy as np
import pytest
from pydantic import ValidationError

from measure import Profile, Quantity, Reading, SensorShare, WheelQuality, WheelReadings
from station.documents import MeasurementDocument, ProfileDocument, WheelDocument, wheel_document

OF_RIGS = {"sensors", "seen_by", "rigs", "by_sensor", "recalibrated"}


def readings(quality, seen_by):
    d = np.arange(4.0)
    return WheelReadings(
        readings={quantity: Reading.missing() for quantity in Quantity},
        profile=Profile(d, d, np.zeros(4), seen_by),
        quality=quality,
        reason=None,
    )


def row(quality=None, seen_by=None):
    answer = readings(quality or WheelQuality(), seen_by)
    return wheel_document(answer, source="a.mcap", sensor="wheel")


@pytest.fixture
def of_rig():
    shares = {
        "inner": SensorShare(points=500),
        "outer": SensorShare(600, aside_mm=(0.1, -0.2), sigma_aside_mm=(0.01, 0.02)),
        "top": SensorShare(0, "no stripe"),
    }
    quality = WheelQuality(sensors=tuple(shares), by_sensor=shares)
    return row(quality, np.array([0b001, 0b011, 0b010, 0b000]))


def names_in(value):
    if isinstance(value, dict):
        yield from value
        value = list(value.values())
    if isinstance(value, list):
        for each in value:
            yield from names_in(each)


def test_of_a_sensor_by_itself_nothing_is_added():
    wheel = row()
    document = MeasurementDocument(
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software="none",
        calibration="0",
        reference="S1002",
        wheels=(wheel,),
    )
    assert OF_RIGS.isdisjoint(names_in(json.loads(document.model_dump_json())))


def test_a_row_of_a_rig_says_which_sensors_gave_what(of_rig):
    assert of_rig.sensors == ("inner", "outer")
    assert of_rig.quality["by_sensor"]["outer"] == {
        "points": 600,
        "reason": None,
        "aside_mm": [0.1, -0.2],
        "sigma_aside_mm": [0.01, 0.02],
    }
    assert of_rig.quality["by_sensor"]["top"]["reason"] == "no stripe"
    profile = of_rig.profile
    assert [profile.seen_by_names(point) for point in range(4)] == [
        ("inner",),
        ("inner", "outer"),
        ("outer",),
        (),
    ]


def test_a_row_read_again_is_the_row_written(of_rig):
    again = WheelDocument.model_validate_json(of_rig.model_dump_json())
    assert again == of_rig
    np.testing.assert_array_equal(again.profile.profile().seen_by, [1, 3, 2, 0])


def test_each_point_of_a_profile_says_who_saw_it_or_none_does():
    three = (0.0, 1.0, 2.0)
    with pytest.raises(ValidationError, match="seen_by has 2 of 3 points"):
        ProfileDocument(d_mm=three, h_mm=three, sigma_mm=three, sensors=("a",), seen_by=(1, 1))
