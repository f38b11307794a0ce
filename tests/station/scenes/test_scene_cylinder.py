"""Does the stripe on a cylinder lie at its radius from its axis?  Without noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib import RigidTransform
from station.scenes import CylinderScene, cylinder_poses


def section_px(scene):
    """Where the lit half of the section is seen, (N, 2), ends left out: they are too dark."""
    pose, plane = scene.cam_from_cylinder, scene.sensor.plane
    angle = np.linspace(0.0, 2.0 * np.pi, 3600, endpoint=False)
    flat = scene.radius_mm * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    # Down the axis to where the sheet is met.
    along = -plane.distance_mm(pose.apply(flat)) / (plane.normal_in_cam @ pose.rotation[:, 2])
    points = pose.apply(flat + along[:, None] * [0.0, 0.0, 1.0])
    outward = flat / scene.radius_mm @ pose.rotation.T
    to_eye = -points / np.linalg.norm(points, axis=1, keepdims=True)
    facing = (outward * to_eye).sum(axis=1) > 0.35
    start = int(np.flatnonzero(~facing & np.roll(facing, -1))[0]) + 1
    order = np.roll(np.arange(3600), -start)
    return scene.sensor.camera.project(points[order][facing[order]])


def test_stripe_lies_at_the_radius_from_the_axis(sensor, clear, ridge_of, rng):
    for pose in cylinder_poses(rng, 2, sensor):
        scene = CylinderScene(sensor, pose, physics=clear)
        light = scene.light_counts() - replace(scene, laser_on=False).light_counts()
        ridge = ridge_of(light, section_px(scene))
        points = pose.inverse().apply(sensor.locate(ridge))
        radius = np.hypot(points[:, 0], points[:, 1])
        lit = light[tuple(np.rint(ridge).astype(int).T[::-1])] > 20.0
        assert lit.sum() > 500
        np.testing.assert_allclose(radius[lit], 30.0, atol=0.02)


def test_every_drawn_cylinder_is_in_view_and_lit(sensor, rng):
    for pose in cylinder_poses(rng, 9, sensor):
        scene = CylinderScene(sensor, pose)
        pixels = section_px(scene)
        assert pixels.min() > 0.0
        assert (pixels < [2048.0, 1088.0]).all()
        tilt = np.degrees(np.arccos(abs(sensor.plane.normal_in_cam @ pose.rotation[:, 2])))
        assert tilt <= 20.0 + 1e-9


def test_picture_shows_a_stripe_only_with_the_laser_on(sensor, rng):
    (pose,) = cylinder_poses(rng, 1, sensor)
    scene = CylinderScene(sensor, pose)
    assert scene.render(rng).max() > 100
    assert replace(scene, laser_on=False).render(rng).max() < 40


@pytest.mark.parametrize("wrong", [{"radius_mm": 0.0}, {"length_mm": np.nan}])
def test_impossible_size_is_refused(sensor, wrong):
    pose = RigidTransform(np.eye(3), np.array([0.0, 0.0, 500.0]))
    with pytest.raises(ValueError, match="must be positive"):
        CylinderScene(sensor, pose, **wrong)


def test_cylinder_around_the_camera_is_refused(sensor):
    pose = RigidTransform(np.eye(3), np.array([0.0, 0.0, 10.0]))
    with pytest.raises(ValueError, match="before the camera"):
        CylinderScene(sensor, pose)


def test_cylinder_too_large_for_the_field_is_refused(sensor, rng):
    with pytest.raises(ValueError, match="no place"):
        cylinder_poses(rng, 1, sensor, radius_mm=400.0)
