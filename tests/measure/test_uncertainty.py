"""The 95 % interval holds the truth 95 times of a hundred, whatever the error comes from."""

import numpy as np
import pytest
import wheel_stripes as ws

from calib import CameraModel, LaserSensor, LightPlane
from measure import Status, WheelFrame, measure_wheel, reference_profile
from measure.gauging.uncertainty import Budget, whitened
from measure.reading import Value
from measure.wheel import generalised_mean

SENSOR, RIG = ws.trackside()
QUANTITIES = ("flange_height", "flange_thickness_10", "flange_thickness_12", "flange_gradient_qr")


def calibration_covariance():
    """A joint covariance with correlations, of the size a calibration of 20 poses leaves."""
    sigma = np.array([0.6, 0.6, 0.8, 0.8, 2e-4, 1e-3, 0.0, 0.0, 0.0, 3e-5, 3e-5, 3e-5, 0.02])
    mixed = np.random.default_rng(0).normal(size=(13, 13))
    covariance = mixed @ mixed.T
    scale = sigma / np.sqrt(np.diag(covariance))
    covariance = covariance * np.outer(scale, scale)
    normal = SENSOR.plane.normal_in_cam
    on_sphere = np.eye(13)
    on_sphere[9:12, 9:12] -= np.outer(normal, normal)
    return on_sphere @ covariance @ on_sphere.T


def one_wheel(covariance, rng):
    """Errors over u95 of one wheel, all sources of error drawn as they are said to be."""
    mounting = ws.mounting_of(RIG)
    wheel = ws.Wheel(
        tread_wear_mm=rng.uniform(0.0, 6.0),
        flange_wear_mm=rng.uniform(0.0, 4.0),
        axle_x_mm=rng.normal(0.0, 20.0),
        radius_mm=rng.normal(420.0, mounting.sigma_radius_mm),
        lateral_mm=rng.normal(0.0, 4.0),
        axle_direction=tuple(rng.normal(0.0, mounting.sigma_axle_direction_rad, 2)),
    )
    stripe = ws.stripe_on(wheel, SENSOR, RIG, rng)
    truth = np.concatenate([SENSOR.camera.parameters, SENSOR.plane.coefficients])
    drawn = rng.multivariate_normal(truth, covariance)
    calibrated = LaserSensor(
        CameraModel.from_parameters(drawn[:9], width=2048, height=1088),
        LightPlane.from_coefficients(drawn[9:]),
        covariance,
    )
    answer = measure_wheel(
        [WheelFrame(stripe, 0, "test")], calibrated, reference_profile("S1002"), mounting=mounting
    )
    readings, true = answer.readings, wheel.truth()
    return [(readings[q].value - true[q]) / readings[q].u95 for q in QUANTITIES]


def coverage(wheels, rng):
    covariance = calibration_covariance()
    scores = np.array([one_wheel(covariance, rng) for _ in range(wheels)])
    return np.mean(np.abs(scores) < 1.0, axis=0)


def test_intervals_hold_the_truth_on_a_few_wheels(rng):
    # Four readings of 60 wheels, half of them independent: 95 +- 2 %; three of those.
    assert coverage(60, rng).mean() == pytest.approx(0.95, abs=0.06)


@pytest.mark.slow
def test_intervals_hold_the_truth_93_to_97_times_of_a_hundred(rng):
    # 1000 wheels pin each share to 0.7 %.
    share = coverage(1000, rng)
    assert (share >= 0.93).all()
    assert (share <= 0.975).all()


def test_whitened_motions_make_up_the_covariance(rng):
    motion = rng.normal(size=(5, 2, 13))
    covariance = calibration_covariance()
    parts = whitened(motion, covariance).reshape(10, -1)
    plain = motion.reshape(10, 13) @ covariance @ motion.reshape(10, 13).T
    np.testing.assert_allclose(parts @ parts.T, plain, rtol=1e-9, atol=1e-12)


def value(mm, single, *shared):
    return Value(mm, Budget(single, np.array(shared)), Status.OK)


def test_pictures_with_opposite_errors_of_one_cause_cancel_it():
    # The same unknown moves one picture up by 1, the other down by 3: three parts to one.
    mean, sigma = generalised_mean([value(1.0, 0.001, 1.0), value(-3.0, 0.001, -3.0)])
    assert mean == pytest.approx(0.0, abs=1e-4)
    # 0.001 x sqrt(0.75^2 + 0.25^2) is left of the pictures' own parts.
    assert sigma == pytest.approx(7.9e-4, rel=0.01)


def test_what_all_pictures_share_no_mean_removes():
    _, sigma = generalised_mean([value(1.0, 0.03, 0.1)] * 9)
    assert sigma == pytest.approx(np.hypot(0.01, 0.1))
