"""Shows that the comparisons of a sensor with its last calibration expect what draws from stated
covariances scatter.  That solved calibrations keep to theirs is shown with the recalibration."""

import numpy as np
import pytest

from calib import (
    PARAMETERS,
    SENSOR_PARAMETERS,
    CameraModel,
    LaserSensor,
    LightPlane,
    compare_sensors,
    compare_sheets,
    compare_update,
    pixel_grid,
)

CAMERA = CameraModel.from_parameters(
    np.array([2000.0, 2000.0, 500.0, 400.0, 0.0, 0.0, 0.0, 0.0, 0.0]), width=1000, height=800
)
PLANE = LightPlane.from_coefficients([0.0, 0.6, -0.8, 300.0])
PIXELS = pixel_grid(1000, 800, 200)
FX, D = SENSOR_PARAMETERS.index("fx"), SENSOR_PARAMETERS.index("d")
FX_SIGMA_PX, D_SIGMA_MM = 2.0, 0.02
DRAWS = 400


def covariance_of(d_by_fx, fx_sigma_px=FX_SIGMA_PX):
    """Return the covariance of a calibration whose plane follows its camera so, in mm/px."""
    covariance = np.zeros((len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS)))
    covariance[FX, FX] = fx_sigma_px**2
    covariance[FX, D] = covariance[D, FX] = d_by_fx * fx_sigma_px**2
    covariance[D, D] = D_SIGMA_MM**2 + d_by_fx**2 * fx_sigma_px**2
    return covariance


def sensor_at(parameters, covariance):
    camera = CameraModel.from_parameters(parameters[: len(PARAMETERS)], width=1000, height=800)
    plane = LightPlane.from_coefficients(parameters[len(PARAMETERS) :])
    return LaserSensor(camera, plane, covariance)


def drawn(rng, covariance):
    truth = np.concatenate([CAMERA.parameters, PLANE.coefficients])
    return truth + rng.multivariate_normal(np.zeros(len(truth)), covariance)


def updated(rng, before, covariance):
    """Draw a calibration whose own pictures leave `covariance`, with the camera before as prior."""
    own = drawn(rng, covariance)
    weight = before.covariance[FX, FX] / (before.covariance[FX, FX] + covariance[FX, FX])
    # One parameter of the camera: the mean of both, and the plane follows by the own pictures.
    fx = before.camera.parameters[FX] + weight * (own[FX] - before.camera.parameters[FX])
    follows = covariance[D, FX] / covariance[FX, FX]
    both = own.copy()
    both[D] += follows * (fx - own[FX])
    both[FX] = fx
    fx_sigma_px = np.sqrt(weight * covariance[FX, FX])
    return sensor_at(both, covariance_of(follows, fx_sigma_px))


def mean_squares(rng, compare, of_before, of_after, *, prior):
    told = []
    for _ in range(DRAWS):
        before = sensor_at(drawn(rng, of_before), of_before)
        after = (
            updated(rng, before, of_after) if prior else sensor_at(drawn(rng, of_after), of_after)
        )
        found = compare(before, after, PIXELS)
        told.append([found.rms_mm**2, found.expected_mm**2])
    return np.mean(told, axis=0)


@pytest.mark.parametrize("prior", [False, True])
@pytest.mark.parametrize("follows", [(0.05, 0.05), (0.0, 0.05), (0.05, -0.02)])
def test_sheets_through_one_camera_scatter_as_expected(rng, follows, prior):
    covariances = [covariance_of(each) for each in follows]
    found, expected = mean_squares(rng, compare_sheets, *covariances, prior=prior)
    # 400 squares of a normal variable: 7 % of scatter, of which four are allowed.
    assert found == pytest.approx(expected, rel=0.28)


def test_whole_sensors_scatter_as_expected_where_the_camera_was_the_prior(rng):
    covariances = covariance_of(0.05), covariance_of(0.05)
    found, expected = mean_squares(rng, compare_update, *covariances, prior=True)
    assert found == pytest.approx(expected, rel=0.28)


def test_sheet_that_follows_its_camera_alike_tells_of_far_smaller_motions(rng):
    covariance = covariance_of(0.05)
    before = sensor_at(drawn(rng, covariance), covariance)
    after = sensor_at(drawn(rng, covariance), covariance)
    sheets = compare_sheets(before, after, PIXELS).expected_mm
    # 0.1 mm that the plane owes to the camera, against 0.02 mm that it does not.
    assert sheets < 0.3 * compare_sensors(before, after, PIXELS).expected_mm


def test_expectation_never_falls_below_what_known_cameras_leave_open(rng):
    # A covariance scaled up by its residuals would take more away than is there.
    before = sensor_at(drawn(rng, covariance_of(0.05)), covariance_of(0.05))
    after = sensor_at(drawn(rng, covariance_of(0.05)), 9.0 * covariance_of(0.05))
    least = np.sqrt(1.0 + 9.0) * D_SIGMA_MM
    found = compare_update(before, after, PIXELS)
    # A plane moved by that much along its normal moves each point farther along its ray.
    assert (found.sigma_mm >= least).all()
