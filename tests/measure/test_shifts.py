"""Shows that a kept profile tells by how much another calibration shifts readings, and how surely.

The truth is the stripe itself, read by both. What speckle and light add is the same in both, and is
not shown here.
"""

import numpy as np
import pytest
import rig_stripes as rs
import wheel_stripes as ws

from calib import LaserSensor, LightPlane, Rig
from measure import (
    OF_A_PROFILE,
    Installation,
    Profile,
    Quantity,
    Shot,
    WheelFrame,
    measure_wheel_on_rig,
    reading_shifts,
    reference_profile,
    relaid,
)

SENSOR, POSE = ws.trackside()
MOUNTING = ws.mounting_of(POSE)
REFERENCE = reference_profile("S1002")
WORN = ws.Wheel(tread_wear_mm=3.0, flange_wear_mm=1.5, axle_x_mm=9.0, lateral_mm=2.0)
MOVED = {"farther": (0.0, 0.0, 0.0, 0.1), "turned": (6e-4, -2e-4, 1e-4, 0.2)}
# A tread may be worn, or lie, alike over centimetres: where these two are read then leaps.
SOUGHT = {Quantity.TREAD_WEAR_MAX, Quantity.HOLLOW_DEPTH}
FIRM = [each for each in OF_A_PROFILE if each not in SOUGHT]


def by_another(sensor, step, covariance=None):
    plane = LightPlane.from_coefficients(sensor.plane.coefficients + np.array(step))
    return LaserSensor(
        sensor.camera, plane, np.zeros((13, 13)) if covariance is None else covariance
    )


def alone(sensor):
    return Installation(Rig.of_one(sensor, POSE, "one"), MOUNTING)


def read(shot, by):
    answer = measure_wheel_on_rig([shot], by.rig, by.survey, REFERENCE)
    assert answer.reason is None
    return answer


def part(profile, mask):
    return Profile(profile.d_mm[mask], profile.h_mm[mask], profile.sigma_mm[mask])


def parts_of(answer, names=("one",)):
    profile = answer.profile
    if profile.seen_by is None:
        return {names[0]: profile}
    return {name: part(profile, profile.seen_by >> bit & 1 == 1) for bit, name in enumerate(names)}


def kept(shot, by, names=("one",)):
    """Return the shot as it is laid back of what a station keeps of the reading."""
    answer = read(shot, by)
    return relaid(parts_of(answer, names), answer.places[0].back_mm, by.rig, by.survey)


def true_shifts(shot, before, after):
    one, other = read(shot, before).readings, read(shot, after).readings
    return {each: other[each].value - one[each].value for each in FIRM}


@pytest.fixture(scope="module")
def stripe():
    return Shot((WheelFrame(ws.stripe_on(WORN, SENSOR, POSE), 1, "test", sensor="one"),))


@pytest.mark.parametrize("step", MOVED.values(), ids=MOVED)
def test_the_shifts_are_those_of_the_stripe_itself(stripe, step):
    before, after = alone(SENSOR), alone(by_another(SENSOR, step))
    found = reading_shifts(kept(stripe, before), before, after, REFERENCE, sensor="one")
    assert found.reason is None
    told = {each.quantity: each.by_mm for each in found.shifts}
    # The kept points are smoothed, and the axle stands in the sheet: 3 % of a shift and 2 um.
    for quantity, true_mm in true_shifts(stripe, before, after).items():
        assert told[quantity] == pytest.approx(true_mm, rel=0.03, abs=0.002), quantity
    assert max(map(abs, told.values())) > 0.01


def test_a_laid_back_profile_reads_as_it_did(stripe):
    before = alone(SENSOR)
    again = read(kept(stripe, before), before).readings
    for quantity, reading in read(stripe, before).readings.items():
        if reading.value is not None and quantity in FIRM:
            assert again[quantity].value == pytest.approx(reading.value, abs=0.02), quantity


def test_the_same_calibration_shifts_nothing(stripe):
    before = alone(SENSOR)
    found = reading_shifts(kept(stripe, before), before, before, REFERENCE, sensor="one")
    assert {(each.by_mm, each.u95_mm, each.within) for each in found.shifts} == {(0.0, 0.0, True)}
    assert found.within


def test_the_uncertainty_is_what_both_calibrations_leave_open(stripe):
    covariance = np.zeros((13, 13))
    covariance[[0, 2], [0, 2]] = 0.5**2, 0.3**2  # px
    covariance[9:13, 9:13] = np.diag([1e-5, 2e-5, 1e-5, 0.03]) ** 2
    covariance[0, 12] = covariance[12, 0] = 0.5 * 0.5 * 0.03
    told = LaserSensor(SENSOR.camera, SENSOR.plane, covariance)
    before, after = alone(SENSOR), alone(told)
    shot = kept(stripe, before)
    found = reading_shifts(shot, before, after, REFERENCE, sensor="one")
    # One sigma along each axis of the covariance, one after the other.
    scale = np.sqrt(np.diag(covariance)) + (np.diag(covariance) == 0.0)
    power, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    moves = (scale[:, None] * axes * np.sqrt(power.clip(min=0.0))).T[power > 1e-12]
    by_axis = [true_shifts(shot, before, alone(moved(SENSOR, each))) for each in moves]
    for shift in found.shifts:
        if shift.quantity in FIRM:
            expected = 1.96 * np.linalg.norm([each[shift.quantity] for each in by_axis])
            assert shift.u95_mm == pytest.approx(expected, rel=0.05), shift.quantity
    both = reading_shifts(shot, after, after, REFERENCE, sensor="one")
    assert both.shifts[0].u95_mm == pytest.approx(np.sqrt(2.0) * found.shifts[0].u95_mm, rel=1e-3)


def moved(sensor, step):
    camera = sensor.camera
    changed = type(camera).from_parameters(
        camera.parameters + step[:9], width=camera.width, height=camera.height
    )
    plane = LightPlane.from_coefficients(sensor.plane.coefficients + step[9:])
    return LaserSensor.exact(changed, plane)


def test_on_a_rig_the_other_sensor_holds_a_reading_as_it_would():
    before = Installation(rs.rig(rs.poses_covariance()), rs.SURVEY)
    inner = before.rig["inner"].sensor
    newer = before.rig.with_sensor("inner", by_another(inner, (0.0, 0.0, 0.0, 0.15)))
    after = Installation(newer, rs.SURVEY)
    shot = rs.shot(WORN)
    found = reading_shifts(
        kept(shot, before, before.rig.names), before, after, REFERENCE, sensor="inner"
    )
    told = {each.quantity: each.by_mm for each in found.shifts}
    # What is learnt of vibration hangs on the noise, which the kept profile tells only on a mean.
    for quantity, true_mm in true_shifts(shot, before, after).items():
        assert told[quantity] == pytest.approx(true_mm, rel=0.1, abs=0.004), quantity
    assert abs(told[Quantity.FLANGE_THICKNESS_10]) > 0.003


def test_what_was_not_seen_is_not_laid_back(stripe):
    before = alone(SENSOR)
    profile = read(stripe, before).profile
    flange, tread = (part(profile, mask) for mask in (profile.d_mm < 50.0, profile.d_mm > 50.0))
    assert relaid({"one": flange}, -70.0, before.rig, MOUNTING) is None
    assert relaid({"one": profile}, 5000.0, before.rig, MOUNTING) is None  # beside the picture
    assert relaid({}, -70.0, before.rig, MOUNTING) is None
    half = relaid({"one": tread}, -70.0, before.rig, MOUNTING)
    found = reading_shifts(half, before, before, REFERENCE, sensor="one")
    assert found.shifts == ()
    assert found.reason
