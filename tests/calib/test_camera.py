"""Projection, rays and their derivatives.  Nothing here says that a lens obeys the model."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calib import PARAMETERS, CameraModel

PARAMETER_VALUES = np.array([2181.0, 2190.0, 1024.0, 544.0, -0.45, 0.25, 1e-3, -2e-3, 0.03])
CAMERA = CameraModel.from_parameters(PARAMETER_VALUES, width=2048, height=1088)
# Steps of central differences, small against each parameter's own size.
STEPS = np.array([1e-2, 1e-2, 1e-2, 1e-2, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5])


def points_in_view(rng, count=50):
    return CAMERA.rays(rng.uniform([0.0, 0.0], [2047.0, 1087.0], (count, 2))) * rng.uniform(
        300.0, 900.0, (count, 1)
    )


def moved(index, step):
    parameters = PARAMETER_VALUES.copy()
    parameters[index] += step
    return CameraModel.from_parameters(parameters, width=2048, height=1088)


def test_projection_agrees_with_opencv(rng):
    points = points_in_view(rng)
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), CAMERA.matrix, CAMERA.distortion
    )
    np.testing.assert_allclose(CAMERA.project(points), expected.reshape(-1, 2), atol=1e-9)


@given(st.floats(0.0, 2047.0), st.floats(0.0, 1087.0))
def test_a_ray_projects_onto_its_pixel(u, v):
    pixel = np.array([[u, v]])
    np.testing.assert_allclose(CAMERA.project(CAMERA.rays(pixel)), pixel, atol=1e-9)


def test_a_pixel_beyond_the_lens_models_fold_has_no_ray():
    # With k1 alone the seen radius r (1 - 0.45 r^2) never exceeds 0.57, which is 1,250 px.
    folded = CameraModel.from_parameters(
        np.array([2181.0, 2181.0, 1024.0, 544.0, -0.45, 0, 0, 0, 0]), width=2048, height=1088
    )
    rays = folded.rays(np.array([[1024.0 + 1300.0, 544.0], [1024.0 + 900.0, 544.0]]))
    assert np.isnan(rays[0, :2]).all()
    assert np.isfinite(rays[1]).all()


def test_projection_jacobians_agree_with_central_differences(rng):
    points = points_in_view(rng)
    pixels, by_point, by_camera = CAMERA.project_with_jacobians(points)
    np.testing.assert_array_equal(pixels, CAMERA.project(points))
    for axis, shift in enumerate(1e-3 * np.eye(3)):
        difference = (CAMERA.project(points + shift) - CAMERA.project(points - shift)) / 2e-3
        # Truncation is of the order of step^2, rounding of 1e-13 * 1e3 px / 1e-3 mm.
        np.testing.assert_allclose(by_point[:, :, axis], difference, atol=1e-6)
    for index, step in enumerate(STEPS):
        ahead, behind = moved(index, step), moved(index, -step)
        difference = (ahead.project(points) - behind.project(points)) / (2.0 * step)
        np.testing.assert_allclose(
            by_camera[:, :, index], difference, atol=1e-6, err_msg=PARAMETERS[index]
        )


def test_ray_jacobians_agree_with_central_differences(rng):
    pixels = rng.uniform([0.0, 0.0], [2047.0, 1087.0], (50, 2))
    rays, by_pixel, by_camera = CAMERA.rays_with_jacobians(pixels)
    np.testing.assert_array_equal(rays, CAMERA.rays(pixels))
    for axis, shift in enumerate(1e-2 * np.eye(2)):
        difference = (CAMERA.rays(pixels + shift) - CAMERA.rays(pixels - shift)) / 2e-2
        np.testing.assert_allclose(by_pixel[:, :, axis], difference, atol=1e-10)
    for index, step in enumerate(STEPS):
        difference = (moved(index, step).rays(pixels) - moved(index, -step).rays(pixels)) / (
            2.0 * step
        )
        np.testing.assert_allclose(
            by_camera[:, :, index], difference, atol=1e-7, err_msg=PARAMETERS[index]
        )


def test_no_pixels_give_no_rays():
    assert CAMERA.rays(np.empty((0, 2))).shape == (0, 3)


@pytest.mark.parametrize(("index", "value"), [(0, 0.0), (1, -5.0), (4, np.nan)])
def test_a_camera_that_cannot_be_is_refused(index, value):
    parameters = PARAMETER_VALUES.copy()
    parameters[index] = value
    with pytest.raises(ValueError, match=r"focal lengths|finite"):
        CameraModel.from_parameters(parameters, width=2048, height=1088)
