"""Two calibrations of one rig side by side.

Shows that the difference is that of the placing alone, and what the covariances make of it.
"""

from dataclasses import replace

import numpy as np
import pytest

from calib import (
    RIG_PARAMETERS,
    CameraMismatch,
    CameraModel,
    LaserSensor,
    LightPlane,
    Rig,
    RigidTransform,
    RigSensor,
    compare_placings,
    moved_by,
    pixel_grid,
)

CAMERA = CameraModel.from_parameters(
    np.array([2400.0, 2400.0, 1023.5, 543.5, 0, 0, 0, 0, 0]), width=2048, height=1088
)
SENSOR = LaserSensor.exact(CAMERA, LightPlane.from_coefficients([0.0, -0.5, -0.8660254, 420.0]))
LEFT = RigidTransform.from_rotation_vector((0.2, -0.4, 0.1), (100.0, -50.0, 20.0))
RIGHT = RigidTransform.from_rotation_vector((-0.3, 0.9, 0.2), (-300.0, 80.0, 60.0))
PIXELS = pixel_grid(2048, 1088, 256)
SIZE = len(RIG_PARAMETERS)


def a_rig(right=RIGHT, sigma=0.0, camera=CAMERA):
    covariance = np.zeros((2 * SIZE, 2 * SIZE))
    covariance[-6:, -6:] = np.diag([sigma * 1e-3] * 3 + [sigma] * 3) ** 2
    sensor = LaserSensor.exact(camera, SENSOR.plane)
    placed = (RigSensor("inner", SENSOR, LEFT), RigSensor("outer", sensor, right))
    return Rig(placed, covariance)


def compared(one, other):
    return compare_placings(one, other, sensor="outer", anchor="inner", pixels_px=PIXELS)


def test_a_shift_of_one_sensor_is_the_difference_everywhere():
    shifted = RigidTransform(RIGHT.rotation, RIGHT.translation_mm + [0.0, 0.3, 0.4])
    np.testing.assert_allclose(compared(a_rig(), a_rig(shifted)).difference_mm, 0.5, atol=1e-9)


def test_a_rig_moved_as_a_whole_is_the_same_rig(rng):
    moved = a_rig(sigma=0.01).moved(
        RigidTransform.from_rotation_vector(rng.normal(size=3), rng.normal(size=3) * 1000.0)
    )
    comparison = compared(a_rig(sigma=0.01), moved)
    np.testing.assert_allclose(comparison.difference_mm, 0.0, atol=1e-9)
    np.testing.assert_allclose(
        comparison.sigma_mm, np.sqrt(2.0) * compared(a_rig(), moved).sigma_mm, rtol=1e-6
    )


@pytest.mark.parametrize("doubtful", ["inner", "outer"])
def test_the_expected_difference_is_the_scatter_of_the_poses(rng, doubtful):
    sigma = np.array([2e-5, 1e-5, 3e-5, 0.02, 0.01, 0.03])
    covariance = np.zeros((2 * SIZE, 2 * SIZE))
    true = replace(a_rig(), covariance=covariance)
    columns = true.columns(doubtful)[-6:]
    covariance[columns, columns] = sigma**2
    known = replace(true, covariance=covariance)
    draws = [
        compared(_drawn(true, doubtful, sigma * rng.normal(size=6)), true).difference_mm
        for _ in range(1000)
    ]
    seen = np.sqrt(np.mean(np.square(draws), axis=0))
    # A root mean square of 1000 draws, mostly of one direction, is sure to 2.3 %; four of those.
    np.testing.assert_allclose(compared(known, true).sigma_mm, seen, rtol=0.1)


def _drawn(rig, name, step):
    return replace(
        rig,
        sensors=tuple(
            replace(each, rig_from_camera=moved_by(each.rig_from_camera, step))
            if each.name == name
            else each
            for each in rig.sensors
        ),
    )


def test_cameras_of_two_sizes_are_refused():
    small = CameraModel.from_parameters(CAMERA.parameters, width=640, height=480)
    with pytest.raises(CameraMismatch, match="outer has pictures of 2048 x 1088 px in one rig, of"):
        compared(a_rig(), a_rig(camera=small))
