"""Points on the sheet and their uncertainty, propagated by derivatives that are checked here."""

import numpy as np
import pytest
from synthetic_views import PAPER_CAMERA, PAPER_PLANE, PAPER_SENSOR

from calib import CameraModel, LaserSensor, LightPlane

PIXELS = np.array([[300.0, 200.0], [1024.0, 544.0], [1500.0, 500.0], [700.0, 600.0]])


def sensor_of(parameters):
    camera = CameraModel.from_parameters(parameters[:9], width=2048, height=1088)
    return camera, parameters[9:]


def locate(parameters, pixels):
    """Locate with any (a, b, c, d), not only a unit normal, as the derivatives have it."""
    camera, plane = sensor_of(parameters)
    rays = camera.rays(pixels)
    return -plane[3] * rays / (rays @ plane[:3])[:, None]


def test_located_points_lie_on_the_sheet_and_project_back():
    points = PAPER_SENSOR.locate(PIXELS)
    np.testing.assert_allclose(PAPER_PLANE.distance_mm(points), 0.0, atol=1e-9)
    np.testing.assert_allclose(PAPER_CAMERA.project(points), PIXELS, atol=1e-9)


def test_location_jacobians_agree_with_central_differences():
    by_pixel, by_sensor = PAPER_SENSOR.location_jacobians(PIXELS)
    truth = np.append(PAPER_CAMERA.parameters, PAPER_PLANE.coefficients)
    np.testing.assert_allclose(locate(truth, PIXELS), PAPER_SENSOR.locate(PIXELS), rtol=1e-12)
    for axis, shift in enumerate(1e-2 * np.eye(2)):
        difference = (locate(truth, PIXELS + shift) - locate(truth, PIXELS - shift)) / 2e-2
        np.testing.assert_allclose(by_pixel[:, :, axis], difference, rtol=1e-6, atol=1e-7)
    steps = np.array([1e-2] * 4 + [1e-5] * 5 + [1e-6] * 3 + [1e-3])
    for index, step in enumerate(steps):
        shift = np.zeros(13)
        shift[index] = step
        difference = (locate(truth + shift, PIXELS) - locate(truth - shift, PIXELS)) / (2 * step)
        # Truncation grows with the second derivative, here at most 1e7 mm: 1e-12 * 1e7.
        np.testing.assert_allclose(by_sensor[:, :, index], difference, rtol=1e-6, atol=1e-4)


def test_predicted_location_scatter_matches_the_scatter_of_drawn_sensors_and_pixels(rng):
    covariance = np.zeros((13, 13))
    covariance[0, 0] = covariance[1, 1] = 0.5**2
    covariance[0, 1] = covariance[1, 0] = 0.9 * 0.5**2
    covariance[12, 12] = 0.02**2
    sensor = LaserSensor(PAPER_CAMERA, PAPER_PLANE, covariance)
    normal = np.tile([0.6, 0.8], (len(PIXELS), 1))
    predicted = sensor.location_covariance(PIXELS, normal, 0.1)
    truth = np.append(PAPER_CAMERA.parameters, PAPER_PLANE.coefficients)
    draws = 1500
    drawn = np.array([
        locate(
            truth + rng.multivariate_normal(np.zeros(13), covariance),
            PIXELS + 0.1 * rng.normal(size=(len(PIXELS), 1)) * normal,
        )
        for _ in range(draws)
    ])
    for index in range(len(PIXELS)):
        observed = np.cov(drawn[:, index].T)
        # 1,500 draws pin a variance to 3.7 %; three of those, relative to the largest entry.
        np.testing.assert_allclose(
            observed, predicted[index], atol=0.11 * np.abs(predicted[index]).max()
        )
        sigma = sensor.sigma_on_sheet(PIXELS, normal, 0.1)[index]
        assert sigma == pytest.approx(np.sqrt(np.linalg.eigvalsh(predicted[index])[-1]))


def test_an_exact_sensor_and_pixel_leave_no_doubt():
    np.testing.assert_array_equal(PAPER_SENSOR.sigma_on_sheet(PIXELS), 0.0)


def test_a_pixel_that_does_not_see_the_sheet_has_no_uncertainty_either():
    behind = LightPlane.from_coefficients([0.0, 0.0, 1.0, 500.0])
    sensor = LaserSensor.exact(PAPER_CAMERA, behind)
    assert np.isnan(sensor.sigma_on_sheet(PIXELS, sigma_px=1.0)).all()


def test_noise_along_both_axes_is_counted_for_a_point_without_direction():
    along_u = PAPER_SENSOR.location_covariance(PIXELS, np.tile([1.0, 0.0], (4, 1)), 0.2)
    along_v = PAPER_SENSOR.location_covariance(PIXELS, np.tile([0.0, 1.0], (4, 1)), 0.2)
    both = PAPER_SENSOR.location_covariance(PIXELS, sigma_px=0.2)
    np.testing.assert_allclose(both, along_u + along_v, atol=1e-15)
