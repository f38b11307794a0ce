"""Are drawn poses usable for calibration: in view, varied, crossed by the sheet?"""

import numpy as np
import pytest

from calib import LaserSensor, LightPlane, RigidTransform, Target
from station.scenes import Light, pose_through_dots, target_poses, target_scenes
from station.scenes.crossing import crossing_on_board


@pytest.fixture(scope="module")
def poses(sensor, target):
    return target_poses(np.random.default_rng(1), 60, sensor, target)


def test_every_dot_is_in_view(sensor, target, poses):
    for pose in poses:
        pixels = sensor.camera.project(pose.apply(target.points_mm))
        assert pixels.min() > 20.0
        assert (pixels < np.array([2048.0, 1088.0]) - 20.0).all()


def test_tilts_lie_between_10_and_35_degrees_and_differ(poses):
    tilts = np.degrees([np.arccos(pose.rotation[2, 2]) for pose in poses])
    assert tilts.min() >= 10.0 - 1e-9
    assert tilts.max() <= 35.0 + 1e-9
    assert tilts.std() > 5.0


def test_places_spread_over_the_field(sensor, target, poses):
    middle = np.array([[42.0, 36.0, 0.0]])
    pixels = np.concatenate([sensor.camera.project(pose.apply(middle)) for pose in poses])
    # Even over their range of about 1500 x 550 px would be 430 and 160.
    assert pixels[:, 0].std() > 250.0
    assert pixels[:, 1].std() > 80.0


def test_stripe_crosses_every_column_between_first_and_last_row(sensor, target, poses):
    for pose in poses:
        for x in (0.0, 84.0):
            column = np.column_stack([np.full(2, x), [0.0, 72.0], np.zeros(2)])
            first, last = sensor.plane.distance_mm(pose.apply(column))
            assert first * last <= 0.0


def test_target_too_large_for_the_field_is_refused(sensor, rng):
    with pytest.raises(ValueError, match="smaller target"):
        target_poses(rng, 1, sensor, Target.parse("dots:20x20:30"))


def test_scenes_come_in_the_order_of_their_lights(sensor, target, rng):
    lights = [Light.DIM, Light.CROSSING, Light.GOOD]
    scenes = target_scenes(rng, sensor, target, lights)
    assert [scene.light for scene in scenes] == lights
    assert len({scene.seed for scene in scenes}) == 3


def test_crossing_is_on_board_and_sheet(sensor, target, poses):
    for pose in poses[:5]:
        crossing = crossing_on_board(sensor.plane, pose, np.array([0.0, 0.0]))
        ends = crossing.nearest_mm + np.outer([-50.0, 50.0], crossing.direction)
        points = pose.apply(np.column_stack([ends, np.zeros(2)]))
        np.testing.assert_allclose(sensor.plane.distance_mm(points), 0.0, atol=1e-9)


def test_sheet_parallel_to_the_board_has_no_crossing(sensor, target):
    parallel = LaserSensor.exact(
        sensor.camera, LightPlane.from_coefficients([0.0, 0.0, 1.0, -480.0])
    )
    pose = RigidTransform(np.eye(3), np.array([0.0, 0.0, 500.0]))
    assert crossing_on_board(parallel.plane, pose, np.zeros(2)) is None
    with pytest.raises(ValueError, match="parallel"):
        pose_through_dots(parallel, target, pose)
