"""Wheels of known shape through the whole of `measure_wheel`, on geometric stripes.

The stripes are exact cuts projected by the camera, with white noise: rendered light, speckle and
steel are the scenes' part and are not shown here.
"""

import time

import numpy as np
import pytest
import wheel_stripes as ws
from hypothesis import given, settings
from hypothesis import strategies as st

from calib import LaserSensor, LightPlane, RigidTransform
from measure import Mounting, Quantity, Status, WheelFrame, measure_wheel, reference_profile

SENSOR, RIG = ws.trackside()
MOUNTING = ws.mounting_of(RIG)
QUANTITIES = (
    "flange_height",
    "flange_thickness_10",
    "flange_thickness_12",
    "flange_gradient_qr",
    "tread_wear",
)


def measured(stripes, *, sensor=SENSOR, reference="S1002", mounting=MOUNTING, **options):
    stripes = stripes if isinstance(stripes, list) else [stripes]
    frames = [WheelFrame(stripe, number, "test") for number, stripe in enumerate(stripes)]
    return measure_wheel(frames, sensor, reference_profile(reference), mounting=mounting, **options)


def errors(wheel, **options):
    answer = measured(**options)
    assert answer.reason is None, answer.reason
    truth = wheel.truth()
    return np.array([answer.readings[q].value - truth[q] for q in QUANTITIES])


def joined(*stripes):
    return ws.make_stripe(
        np.concatenate([stripe.centre_px for stripe in stripes]),
        np.concatenate([stripe.normal for stripe in stripes]),
    )


def no_value(answer):
    return all(r.value is None and r.status is Status.MISSING for r in answer.readings.values())


@pytest.mark.parametrize("reference", ["S1002", "LMA"])
def test_worn_wheels_are_read_within_the_demanded_rms(reference, rng):
    off = []
    for tread_wear in np.linspace(0.0, 8.0, 8):
        wheel = ws.Wheel(
            reference=reference,
            tread_wear_mm=tread_wear,
            flange_wear_mm=0.5 * tread_wear,
            lateral_mm=rng.normal(0.0, 3.0),
        )
        stripe = ws.stripe_on(wheel, SENSOR, RIG, rng)
        off.append(errors(wheel, stripes=stripe, reference=reference))
    height, at_10, at_12, gradient, wear = np.sqrt(np.mean(np.square(off), axis=0))
    # The demands of the station at 0.05 px of stripe noise; measured: 0.006, 0.008, 0.010, 0.015.
    assert max(height, wear) <= 0.02
    assert max(at_10, at_12) <= 0.03
    assert gradient <= 0.06


@pytest.mark.parametrize("axle_x_mm", [-80.0, -40.0, 40.0, 80.0])
def test_an_oblique_cut_is_mapped_back(axle_x_mm, rng):
    sensor, rig = ws.trackside(yaw_deg=3.0)
    wheel = ws.Wheel(tread_wear_mm=2.0, axle_x_mm=axle_x_mm, radius_mm=424.0)
    stripe = ws.stripe_on(wheel, sensor, rig, rng)
    answer = measured(stripe, sensor=sensor, mounting=ws.mounting_of(rig))
    truth = wheel.truth()
    for quantity in ("flange_height", "flange_thickness_10", "tread_wear"):
        # Taken for radial, 40 mm off the sheet and 3 degrees would cost 0.3 mm.
        assert answer.readings[quantity].value == pytest.approx(truth[quantity], abs=0.05)
    assert answer.quality.axle_offset_mm == pytest.approx(abs(axle_x_mm) / 2.0, abs=6.0)
    assert answer.quality.sheet_yaw_deg == pytest.approx(3.0, abs=0.01)


def test_several_frames_of_a_wheel_are_better_than_one(rng):
    wheels = [ws.Wheel(tread_wear_mm=3.0, axle_x_mm=x) for x in (-60.0, -30.0, 0.0, 30.0, 60.0)]
    stripes = [ws.stripe_on(wheel, SENSOR, RIG, rng) for wheel in wheels]
    together, alone = measured(stripes), measured(stripes[0])
    wear = together.readings[Quantity.TREAD_WEAR]
    assert together.quality.frames == (0, 1, 2, 3, 4)
    assert wear.u95 < alone.readings[Quantity.TREAD_WEAR].u95
    assert wear.value == pytest.approx(wheels[0].truth()["tread_wear"], abs=0.02)
    # The survey's tilt of the axle, shared by all frames, is averaged by none of them.
    assert wear.u95 > 1.9 * 0.9 * 55.0 * MOUNTING.sigma_axle_direction_rad


def test_a_broader_stripe_is_drawn_farther_and_trusted_less(monkeypatch):
    narrow = measured(ws.stripe_on(ws.Wheel(), SENSOR, RIG)).readings
    monkeypatch.setattr(ws, "WIDTH_PX", 2.6)
    broad = measured(ws.stripe_on(ws.Wheel(), SENSOR, RIG)).readings
    for quantity in ("flange_thickness_10", "flange_gradient_qr"):
        # Undone to a part: 2.6^2 + 3^2 px² are four times the 1.2^2 + 1.5^2 of before.
        assert broad[quantity].value == pytest.approx(narrow[quantity].value, abs=0.04)
        assert broad[quantity].u95 > 1.3 * narrow[quantity].u95


def test_frames_that_show_nothing_are_told_and_do_not_harm(rng):
    good = ws.stripe_on(ws.Wheel(), SENSOR, RIG, rng)
    empty = good.select(np.arange(5))
    answer = measured([empty, good])
    assert answer.reason is None
    assert answer.quality.frames == (1,)
    assert "no stripe" in answer.quality.unmeasured[0]


def test_without_a_survey_the_reference_is_assumed_and_says_so(rng):
    wheel = ws.Wheel(tread_wear_mm=3.0, flange_wear_mm=2.0)
    answer = measured(ws.stripe_on(wheel, SENSOR, RIG, rng), mounting=None)
    truth = wheel.truth()
    for quantity in QUANTITIES:
        reading = answer.readings[quantity]
        assert reading.status is Status.REFERENCE_ASSUMED
        assert abs(reading.value - truth[quantity]) <= reading.u95
    assert answer.quality.axle_offset_mm is None
    # The flange's shape gives the direction to 3 mrad, 55 mm of tip and tread apart.
    assert answer.readings[Quantity.FLANGE_HEIGHT].u95 > 1.96 * 3e-3 * 50.0


def test_an_unseen_flange_back_takes_the_thickness(rng):
    stripe = ws.stripe_on(ws.Wheel(span_y_mm=(-69.0, 99.0)), SENSOR, RIG, rng)
    answer = measured(stripe)
    for quantity in QUANTITIES[1:4]:
        assert answer.readings[quantity].status is Status.MISSING
    height = answer.readings[Quantity.FLANGE_HEIGHT]
    assert height.status is Status.REFERENCE_ASSUMED
    assert abs(height.value - 28.0) <= height.u95


def test_an_unseen_flange_back_may_be_assumed_at_its_price(rng):
    stripe = ws.stripe_on(ws.Wheel(span_y_mm=(-69.0, 99.0)), SENSOR, RIG, rng)
    thickness = measured(stripe, assume_back=True).readings[Quantity.FLANGE_THICKNESS_10]
    assert thickness.status is Status.REFERENCE_ASSUMED
    assert abs(thickness.value - 32.5) <= thickness.u95
    assert thickness.u95 > 0.9


@pytest.mark.parametrize("mounting", [MOUNTING, None], ids=["surveyed", "unsurveyed"])
@pytest.mark.parametrize(
    ("case", "reason"),
    [
        ("dark", "no stripe"),
        ("specks", "no stripe"),
        ("line", "no wheel"),
        ("tread only", "no wheel"),
        ("flange only", "half a wheel"),
        ("two wheels", "two wheels"),
        ("upside down", "wheel"),
        ("mirrored", "wheel"),
    ],
)
def test_what_is_no_wheel_gives_a_reason_and_no_value(case, reason, mounting, rng):
    answer = measured(unmeasurable(case, rng), mounting=mounting)
    assert reason in answer.reason
    assert no_value(answer)
    assert answer.profile is None


def unmeasurable(case, rng):
    def of(**wheel):
        return ws.stripe_on(ws.Wheel(**wheel), SENSOR, RIG, rng)

    if case == "dark":
        return of().select(np.arange(0))
    if case == "specks":
        return specks(rng)
    if case == "line":
        return line()
    if case == "tread only":
        return of(span_y_mm=(-34.0, 99.0))
    if case == "flange only":
        return of(span_y_mm=(-71.0, -20.0))
    if case == "two wheels":
        return joined(of(lateral_mm=-80.0), of(lateral_mm=70.0, tread_wear_mm=2.0))
    whole = of()
    if case == "upside down":
        return ws.make_stripe(np.array([2047.0, 1087.0]) - whole.centre_px, -whole.normal)
    return ws.make_stripe(whole.centre_px * [1.0, -1.0] + [0.0, 1087.0], whole.normal * [1.0, -1.0])


def specks(rng, count=600):
    angle = rng.uniform(0.0, np.pi, count)
    return ws.make_stripe(
        rng.uniform([0.0, 0.0], [2047.0, 1087.0], (count, 2)),
        np.column_stack([np.cos(angle), np.sin(angle)]),
    )


def line():
    u = np.linspace(100.0, 1900.0, 1800)
    normal = np.array([-1.0, 30.0]) / np.hypot(1.0, 30.0)
    return ws.make_stripe(np.column_stack([u, 500.0 + u / 30.0]), np.tile(normal, (1800, 1)))


@pytest.mark.parametrize("stray", ["specks", "line", "reflection", "outliers"])
def test_stray_points_change_nothing_that_matters(stray, rng):
    stripe = ws.stripe_on(ws.Wheel(), SENSOR, RIG, rng)
    clean = measured(stripe)
    if stray == "outliers":
        jump = np.where(
            rng.random((len(stripe), 1)) < 0.1, rng.normal(0.0, 3.0, (len(stripe), 1)), 0
        )
        spoilt = ws.make_stripe(stripe.centre_px + jump * stripe.normal, stripe.normal)
    else:
        ghost = stripe.select(np.arange(450, 650))
        other = {
            "specks": specks(rng),
            "line": line(),
            "reflection": ws.make_stripe(ghost.centre_px + [0.0, 12.0], ghost.normal),
        }[stray]
        spoilt = joined(stripe, other)
    answer = measured(spoilt)
    assert sum(answer.quality.left_out.values()) >= 0.5 * (len(spoilt) - len(stripe))
    for quantity in QUANTITIES:
        before, after = clean.readings[quantity], answer.readings[quantity]
        # One sigma of the noise on these readings is 0.01 mm.
        assert after.value == pytest.approx(before.value, abs=0.03)


@pytest.mark.parametrize("offset_mm", [-25.0, 25.0])
def test_of_a_sheet_and_its_reflection_the_true_one_is_read(offset_mm, rng):
    a, b, c, d = SENSOR.plane.coefficients
    # A mirror sends part of the light along another sheet: its cut has another shape.
    other = LightPlane.from_coefficients([a, b, c + 0.06, d + offset_mm])
    false = ws.stripe_on(ws.Wheel(), LaserSensor.exact(SENSOR.camera, other), RIG, rng)
    true = ws.stripe_on(ws.Wheel(), SENSOR, RIG, rng)
    both, clean = measured(joined(false, true)), measured(true)
    for quantity in QUANTITIES:
        value = clean.readings[quantity].value
        assert both.readings[quantity].value == pytest.approx(value, abs=0.03)


def test_the_order_of_points_does_not_matter(rng):
    stripe = ws.stripe_on(ws.Wheel(), SENSOR, RIG, rng)
    shuffled = stripe.select(rng.permutation(len(stripe)))
    for quantity, reading in measured(stripe).readings.items():
        again = measured(shuffled).readings[quantity]
        # Which points of a stripe vote for its place depends on their order, a little.
        assert again.value == pytest.approx(reading.value, abs=2e-3)


@settings(deadline=None, max_examples=8)
@given(st.floats(-500.0, 500.0), st.floats(-500.0, 500.0))
def test_moving_sensor_and_wheel_together_changes_nothing(along_mm, across_mm):
    rng = np.random.default_rng(7)
    stripe = ws.stripe_on(ws.Wheel(tread_wear_mm=2.0), SENSOR, RIG, rng)
    moved = RigidTransform(np.eye(3), np.array([along_mm, across_mm, 0.0])) @ RIG
    before = measured(stripe).readings
    after = measured(stripe, mounting=Mounting(moved, wheel_radius_mm=ws.RADIUS_MM)).readings
    for quantity, reading in before.items():
        assert after[quantity].value == pytest.approx(reading.value, abs=1e-6)
        assert after[quantity].u95 == pytest.approx(reading.u95, abs=1e-6)


@pytest.mark.parametrize("surveyed", [True, False])
def test_the_right_side_reads_like_the_left(surveyed, rng):
    stripe = ws.stripe_on(ws.Wheel(tread_wear_mm=2.0), SENSOR, RIG, rng)
    # In a mirror along the rail the left sensor and its picture are those of the right rail.
    mirrored = ws.make_stripe(
        stripe.centre_px * [-1.0, 1.0] + [2.0 * SENSOR.camera.cx, 0.0], stripe.normal * [-1.0, 1.0]
    )
    sensor, rig = ws.mirrored(SENSOR, RIG)
    left = measured(stripe, mounting=MOUNTING if surveyed else None)
    right = measured(mirrored, sensor=sensor, mounting=ws.mounting_of(rig) if surveyed else None)
    for quantity in QUANTITIES:
        assert right.readings[quantity].value == pytest.approx(
            left.readings[quantity].value, abs=1e-4
        )


def test_profile_lies_on_the_wheel_it_was_read_from(rng):
    wheel = ws.Wheel(tread_wear_mm=3.0, flange_wear_mm=2.0)
    profile = measured(ws.stripe_on(wheel, SENSOR, RIG, rng)).profile
    truth = wheel.points() + [70.0, 0.0]
    truth[:, 1] += 28.0 - truth[:, 1].max()
    gap = [np.hypot(*(truth - point).T).min() for point in profile.points_mm]
    # Half-millimetre means of two points scatter by 0.012 mm; datum errors add 0.01.
    assert np.sqrt(np.mean(np.square(gap))) < 0.025


def test_no_frames_at_all_is_a_reason():
    assert measured([]).reason == "no picture of this wheel"


def test_one_frame_takes_tens_of_milliseconds_at_most(rng):
    stripe = ws.stripe_on(ws.Wheel(tread_wear_mm=2.0), SENSOR, RIG, rng)
    spent = []
    while len(spent) < 12 or (min(spent) > 0.05 and len(spent) < 100):
        start = time.thread_time()
        measured(stripe)
        spent.append(time.thread_time() - start)
    # 17 ms on a quiet core, where 25 are allowed; a core shared with others takes twice as long.
    assert min(spent) <= 0.05
