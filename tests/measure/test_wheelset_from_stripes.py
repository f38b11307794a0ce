"""From the stripes of several sensors to diameter and back-to-back distance: what a rig says of
where the wheel stood is what these are made of.  Stripes are exact cuts with white noise; light and
steel are the scenes' part."""

import numpy as np
import pytest
import rig_stripes as rs
import wheel_stripes as ws

from calib import RIG_PARAMETERS, Rig, RigidTransform, RigSensor
from measure import (
    Quantity,
    Shot,
    Status,
    Survey,
    TrackFrame,
    WheelFrame,
    back_to_back,
    measure_wheel_on_rig,
    reference_profile,
)

S1002 = reference_profile("S1002")
# Sheets ahead of the axle, below it and behind it.
AROUND = {
    "ahead": ws.trackside(below_deg=20.0),
    "under": ws.trackside(below_deg=60.0),
    "behind": ws.trackside(below_deg=160.0),
}
STIFF = Survey(sigma_vibration_mm=0.02)
BETWEEN_MM = 1500.0
OPPOSITE = TrackFrame(
    RigidTransform(np.diag([-1.0, -1.0, 1.0]), np.array([0.0, -BETWEEN_MM, 0.0])),
    np.zeros((6, 6)),
)


def rig_of(stands):
    size = len(stands) * len(RIG_PARAMETERS)
    sensors = tuple(RigSensor(name, *stand) for name, stand in stands.items())
    return Rig(sensors, np.zeros((size, size)))


def measured(stands, wheels, rng, survey=STIFF):
    """What is said of a wheel that stood, shot after shot, as told."""
    shots = [
        Shot(
            tuple(
                WheelFrame(ws.stripe_on(wheel, *stand, rng), at, name, at * 19_000_000, name)
                for name, stand in stands.items()
            )
        )
        for at, wheel in enumerate(wheels)
    ]
    return measure_wheel_on_rig(shots, rig_of(stands), survey, S1002)


@pytest.mark.parametrize("radius", [413.0, 426.0])
def test_three_sheets_around_a_wheel_tell_its_diameter(rng, radius):
    wheels = [ws.Wheel(radius_mm=radius, axle_x_mm=x, lateral_mm=1.0) for x in (-40.0, 0.0, 40.0)]
    answer = measured(AROUND, wheels, rng)
    reading = answer.readings[Quantity.DIAMETER]
    assert reading.status is Status.OK
    assert reading.u95 < 0.06
    # Noise of 0.05 px is 0.01 mm a point and 1 um a tread; the parabola leaves 2 um of a tread.
    assert reading.value == pytest.approx(2.0 * radius, abs=0.02)


def test_an_inner_and_an_outer_sheet_tell_no_diameter_and_why(rng):
    wheels = [ws.Wheel(axle_x_mm=x) for x in (-40.0, 0.0, 40.0)]
    answer = measured(rs.STANDS, wheels, rng, rs.SURVEY)
    assert answer.readings[Quantity.DIAMETER].status is Status.MISSING
    # 15 degrees apart on one side of the wheel.
    assert "height over the rail is known to 1 mm" in answer.diameter.reason


def test_a_lone_sensor_tells_no_diameter(rng):
    wheels = [ws.Wheel(axle_x_mm=x) for x in (-40.0, 0.0, 40.0)]
    answer = measured({"only": ws.trackside()}, wheels, rng)
    assert answer.readings[Quantity.DIAMETER].status is Status.MISSING
    assert answer.diameter.reason.startswith("0 of 3 shots show the tread by two sheets")


@pytest.mark.parametrize("names", [("inner", "outer"), ("inner",)])
def test_the_place_of_a_flange_back_bears_the_vibration_of_the_sensors(rng, names):
    answer = measured({name: rs.STANDS[name] for name in names}, [ws.Wheel()], rng, rs.SURVEY)
    # Two sensors differ by 0.3 mm, each moves by that over root 2; the mean of two by half of it.
    vibration = 0.3 / np.sqrt(2.0 * len(names))
    assert answer.places[0].back.single_mm == pytest.approx(vibration, rel=0.02)


def test_two_rigs_tell_the_distance_of_an_axle_that_yaws(rng):
    yaw, lateral = 3e-3, 1.5
    left_wheels = [
        ws.Wheel(axle_x_mm=x, lateral_mm=lateral, axle_direction=(yaw, 0.0)) for x in (-20.0, 20.0)
    ]
    # The same axle from the right: half a turn about the vertical leaves its slope as it is.
    right_wheels = [
        ws.Wheel(
            axle_x_mm=-wheel.axle_x_mm + BETWEEN_MM * yaw,
            lateral_mm=-lateral,
            axle_direction=(yaw, 0.0),
        )
        for wheel in left_wheels
    ]
    left = measured({"left": ws.trackside(below_deg=40.0)}, left_wheels, rng)
    right = measured({"right": ws.trackside(below_deg=140.0)}, right_wheels, rng)
    # The flange back is seen where the sheets meet it, 40 degrees below the axle on both sides.
    at = np.array([0.0, ws.RADIUS_MM]) + ws.RADIUS_MM * np.array([np.cos(0.7), -np.sin(0.7)])
    np.testing.assert_allclose(left.places[0].back_at_mm, at, atol=30.0)
    np.testing.assert_allclose(right.places[0].back_at_mm, at * [-1.0, 1.0], atol=30.0)
    found = back_to_back(left.places, right.places, OPPOSITE)
    # Measured along rig y, 1500 mm between tape circles less twice 70: yaw adds 6 um to that, and
    # cancels but for the 8 um that turning each section about its tape circle makes of 3 mrad.
    along_axle = (BETWEEN_MM - 140.0) * np.hypot(1.0, yaw)
    assert found.pairs == 2
    assert found.value_mm == pytest.approx(along_axle, abs=0.1)
    assert abs(found.value_mm - along_axle) < found.u95_mm
