"""New wheels become a reference: its noise is not read as wear twice, its doubt is kept.

Points are drawn about the drawing with independent noise; what a sensor's calibration adds is only
carried along, as the u95 of the readings.
"""

from dataclasses import replace

import numpy as np
import pytest
from wheel_stripes import Wheel, mounting_of, stripe_on, trackside

from measure import (
    NewWheel,
    Profile,
    Quantity,
    Reading,
    ReferenceInvalid,
    ReferenceProfile,
    Status,
    WheelFrame,
    gauge_profile,
    measure_wheel,
    reference_of_new_wheels,
    reference_profile,
)

S1002 = reference_profile("S1002")
HEIGHT = Quantity.FLANGE_HEIGHT
WEAR = (Quantity.TREAD_WEAR, Quantity.TREAD_WEAR_AT_70, Quantity.TREAD_WEAR_MAX)


def new_wheel(rng, sigma_mm=0.02, step_mm=0.5, shape=S1002, raised_mm=0.0):
    d, h = (shape.points(step_mm, back_face_mm=20.0) + [70.0, 0.0]).T
    # The flange grows out of the tread smoothly: 14 mm ahead of it nothing moves.
    h = h + raised_mm * np.clip((50.0 - d) / 20.0, 0.0, 1.0)
    noise = rng.normal(0.0, sigma_mm, (2, len(d)))
    profile = Profile(d + noise[0], h + noise[1], np.full(len(d), sigma_mm))
    return NewWheel(profile, gauge_profile(profile, S1002).readings)


def test_a_reference_of_one_wheel_keeps_its_readings_and_their_doubt(rng):
    wheel = new_wheel(rng)
    measured = reference_of_new_wheels([wheel])
    reference = measured.profile("new")
    for quantity, value in measured.nominal.items():
        assert value == wheel.readings[quantity].value
        assert measured.u95[quantity] == wheel.readings[quantity].u95
    assert reference.nominal[HEIGHT] == wheel.readings[HEIGHT].value
    assert reference.sigma_mm(Quantity.TREAD_WEAR) == pytest.approx(measured.u95[HEIGHT] / 1.96)
    assert reference.sigma_mm(HEIGHT) == 0.0
    assert measured.spread == {}


def test_smoothed_points_are_nearer_to_the_drawing_than_measured_ones(rng):
    measured = reference_of_new_wheels([new_wheel(rng)])
    y = np.linspace(-20.0, 50.0, 200)
    off = measured.profile("new").height_mm(y) - S1002.height_mm(y)
    # A parabola over 6 mm of points every 0.5 mm leaves sqrt(9 / (4 x 12)) of 0.02 mm.
    assert off.std() < 0.011
    assert np.median(measured.sigma_mm) == pytest.approx(0.0087, rel=0.15)


def test_the_mean_of_wheels_is_surer_in_shape_and_owns_to_their_spread(rng):
    wheels = [new_wheel(rng, raised_mm=raised) for raised in (-0.04, 0.0, 0.02, 0.06)]
    measured = reference_of_new_wheels(wheels)
    heights = [wheel.readings[HEIGHT].value for wheel in wheels]
    assert measured.nominal[HEIGHT] == pytest.approx(np.mean(heights))
    assert measured.spread[HEIGHT] == pytest.approx(np.std(heights, ddof=1))
    own = np.mean([wheel.readings[HEIGHT].u95 for wheel in wheels])
    # t(0.975, 3) = 3.182.
    of_mean = 3.182 * measured.spread[HEIGHT] / 2.0
    assert measured.u95[HEIGHT] == pytest.approx(np.hypot(own, of_mean), rel=1e-3)
    single = reference_of_new_wheels(wheels[:1])
    y = np.linspace(-20.0, 50.0, 200)
    truth = S1002.height_mm(y)
    rest = [np.std(found.profile("new").height_mm(y) - truth) for found in (measured, single)]
    assert rest[0] < 0.8 * rest[1]


def test_wear_counted_from_a_measured_reference_says_how_sure_that_is(rng):
    reference = reference_of_new_wheels([new_wheel(rng)]).profile("new")
    exact = new_wheel(rng, sigma_mm=0.002)
    by_drawing = gauge_profile(exact.profile, S1002).readings
    by_measured = gauge_profile(exact.profile, reference).readings
    for quantity in WEAR:
        found = by_measured[quantity]
        expected = np.hypot(by_drawing[quantity].u95, 1.96 * reference.height_sigma_mm)
        assert found.u95 == pytest.approx(expected, rel=0.02)
        # A new wheel is not worn; the greatest of 60 differences lies three sigmas out.
        assert abs(found.value) < 1.6 * found.u95
    for quantity in (HEIGHT, Quantity.FLANGE_THICKNESS_10, Quantity.HOLLOW_DEPTH):
        assert by_measured[quantity] == by_drawing[quantity]


def test_intervals_of_wear_from_a_measured_reference_cover_the_truth(rng):
    inside = 0
    for _ in range(60):
        reference = reference_of_new_wheels([new_wheel(rng)]).profile("new")
        worn = new_wheel(rng)
        reading = gauge_profile(worn.profile, reference).readings[Quantity.TREAD_WEAR]
        inside += abs(reading.value) <= reading.u95
    # 95 % of 60 are 57; six or more outside happen to one in 30, nine or more to one in 2,000.
    assert inside >= 52


def test_another_height_of_the_file_does_not_matter(rng):
    wheel = new_wheel(rng, sigma_mm=0.002)
    raised = replace(wheel.profile, h_mm=wheel.profile.h_mm + 420.0)
    one, other = (
        reference_of_new_wheels([NewWheel(profile, wheel.readings)])
        for profile in (wheel.profile, raised)
    )
    np.testing.assert_allclose(one.points_mm, other.points_mm, atol=1e-6)


def test_more_pictures_do_not_make_a_measured_reference_surer(rng):
    sensor, rig_from_camera = trackside()
    stripes = [stripe_on(Wheel(), sensor, rig_from_camera, rng) for _ in range(4)]
    frames = [WheelFrame(stripe, number, "test") for number, stripe in enumerate(stripes)]
    doubtful = replace(S1002, height_sigma_mm=0.05)
    mounting = mounting_of(rig_from_camera)
    for seen in (frames[:1], frames):
        by_drawing, by_measured = (
            measure_wheel(seen, sensor, reference, mounting=mounting).readings
            for reference in (S1002, doubtful)
        )
        for quantity in WEAR:
            expected = np.hypot(by_drawing[quantity].u95, 1.96 * 0.05)
            assert by_measured[quantity].u95 == pytest.approx(expected, rel=1e-6)
        assert by_measured[HEIGHT] == by_drawing[HEIGHT]


def with_reading(wheel, quantity, reading):
    return NewWheel(wheel.profile, {**wheel.readings, quantity: reading})


def test_wheels_that_make_no_reference_are_refused(rng):
    wheel = new_wheel(rng)
    with pytest.raises(ReferenceInvalid, match="no new wheel"):
        reference_of_new_wheels([])
    with pytest.raises(ReferenceInvalid, match="wheel 2 of 2: flange_height is missing"):
        reference_of_new_wheels([wheel, with_reading(wheel, HEIGHT, Reading.missing())])
    leaning = replace(wheel.readings[HEIGHT], status=Status.REFERENCE_ASSUMED)
    with pytest.raises(ReferenceInvalid, match="reference_assumed"):
        reference_of_new_wheels([with_reading(wheel, HEIGHT, leaning)])
    with pytest.raises(ReferenceInvalid, match="leave out what is worn"):
        reference_of_new_wheels([wheel, new_wheel(rng, raised_mm=1.0)])
    d, h = wheel.profile.d_mm, wheel.profile.h_mm
    hole = (d > 80.0) & (d < 90.0)
    holed = Profile(d[~hole], h[~hole], wheel.profile.sigma_mm[~hole])
    with pytest.raises(ReferenceInvalid, match=r"a gap of 1\d\.\d mm at d = 79"):
        reference_of_new_wheels([NewWheel(holed, wheel.readings)])


def test_points_and_readings_of_different_wheels_are_no_reference():
    points = S1002.points(0.25)
    nominal = {**S1002.nominal, HEIGHT: 28.2}
    with pytest.raises(ReferenceInvalid, match=r"flange_height of the points is 28\.000"):
        ReferenceProfile.measured("mixed", points, nominal, 0.01)
    with pytest.raises(ReferenceInvalid, match="None"):
        ReferenceProfile.measured("bare", points, {}, 0.01)
    with pytest.raises(ReferenceInvalid, match="sigma"):
        ReferenceProfile.measured("doubtful", points, S1002.nominal, float("nan"))
