"""Sensors in one frame: what is known of them together."""

import numpy as np
import pytest

from calib import (
    RIG_PARAMETERS,
    CameraModel,
    LaserSensor,
    LightPlane,
    Rig,
    RigidTransform,
    RigSensor,
    moved_by,
)

SIZE = len(RIG_PARAMETERS)
PARAMETERS = np.array([2315.0, 2312.0, 1004.0, 555.0, -0.12, 0.12, 0.0, 0.0, 0.0])
PIXELS = np.array([[300.0, 200.0], [1000.0, 500.0], [1800.0, 900.0]])
SCALES = np.array([1.0, 1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-5, 1e-5, 1e-3, 1e-4, 1e-4, 1e-4, 0.05])
POSE_SCALES = np.array([1e-4, 1e-4, 1e-4, 0.02, 0.02, 0.02])


def sensor(step=None):
    """A sensor, perhaps with other parameters."""
    parameters = np.concatenate([
        PARAMETERS,
        LightPlane.from_coefficients([0.015, 0.8186, -0.5742, 279.06]).coefficients,
    ])
    parameters = parameters + (0.0 if step is None else step)
    camera = CameraModel.from_parameters(parameters[:9], width=2048, height=1088)
    return LaserSensor.exact(camera, LightPlane.from_coefficients(parameters[9:]))


def rig(rng):
    """Two sensors with a full joint covariance."""
    poses = [
        RigidTransform.from_rotation_vector(rng.normal(size=3), rng.normal(0.0, 500.0, 3))
        for _ in range(2)
    ]
    root = rng.normal(size=(2 * SIZE, 2 * SIZE)) / np.sqrt(2 * SIZE)
    root *= np.tile(np.concatenate([SCALES, POSE_SCALES]), 2)[:, None]
    sensors = (RigSensor("a", sensor(), poses[0]), RigSensor("b", sensor(), poses[1]))
    return Rig(sensors, root @ root.T)


def test_another_frame_moves_all_points_alike_and_turns_the_covariance(rng):
    one = rig(rng)
    other_from_rig = RigidTransform.from_rotation_vector([0.3, -0.2, 0.5], [10.0, 20.0, 30.0])
    moved = one.moved(other_from_rig)
    for name in ("a", "b"):
        there = moved[name].locate(PIXELS)
        np.testing.assert_allclose(there, other_from_rig.apply(one[name].locate(PIXELS)), atol=1e-9)
    # A small step of a pose, said in either frame, moves the points by the same.
    step = rng.normal(size=6) * POSE_SCALES
    turned = np.concatenate([
        other_from_rig.rotation @ step[:3],
        other_from_rig.rotation @ step[3:],
    ])
    points = one["a"].sensor.locate(PIXELS)
    before = other_from_rig.apply(moved_by(one["a"].rig_from_camera, step).apply(points))
    after = moved_by(moved["a"].rig_from_camera, turned).apply(points)
    np.testing.assert_allclose(after, before, atol=1e-9)
    shifts = one.columns("a")[-3:]
    turn = other_from_rig.rotation
    np.testing.assert_allclose(
        moved.covariance[np.ix_(shifts, shifts)],
        turn @ one.covariance[np.ix_(shifts, shifts)] @ turn.T,
        atol=1e-15,
    )


def test_a_later_calibration_moves_the_pose_as_regression_says(rng):
    one = rig(rng)
    own, pose = one.columns("a")[:13], one.columns("b")[-6:]
    gain = one.covariance[np.ix_(pose, own)] @ np.linalg.inv(one.covariance[np.ix_(own, own)])
    step = rng.normal(size=13) * SCALES * 0.1
    step[9:] = 0.0  # A plane's coefficients are tied by their length.
    later = one.with_sensor("a", sensor(step))
    expected = moved_by(one["b"].rig_from_camera, gain @ step)
    # Pseudo-inverse of a correlation matrix of condition 1e4 or so: six digits.
    np.testing.assert_allclose(
        later["b"].rig_from_camera.translation_mm, expected.translation_mm, atol=1e-6
    )
    np.testing.assert_allclose(later["b"].rig_from_camera.rotation, expected.rotation, atol=1e-9)
    assert later["a"].sensor.camera.parameters[0] == pytest.approx(PARAMETERS[0] + step[0])


def test_what_a_sensor_is_known_exactly_for_is_taken_from_the_poses(rng):
    one = rig(rng)
    later = one.with_sensor("a", sensor())
    own, pose = one.columns("a")[:13], one.columns("b")[-6:]
    assert not later.covariance[own].any()
    left = np.diag(later.covariance)[pose]
    assert (left < np.diag(one.covariance)[pose]).all()
    assert np.linalg.eigvalsh(later.covariance[np.ix_(pose, pose)]).min() > 0.0


def test_the_same_calibration_changes_nothing_of_the_poses(rng):
    one = rig(rng)
    own = one.columns("a")[:13]
    same = LaserSensor(
        one["a"].sensor.camera, one["a"].sensor.plane, one.covariance[np.ix_(own, own)]
    )
    later = one.with_sensor("a", same)
    poses = np.concatenate([one.columns("a")[-6:], one.columns("b")[-6:]])
    np.testing.assert_allclose(
        later.covariance[np.ix_(poses, poses)],
        one.covariance[np.ix_(poses, poses)],
        rtol=1e-6,
        atol=1e-12,
    )


def test_one_sensor_is_a_rig_whose_pose_is_beyond_doubt():
    one = Rig.of_one(sensor(), RigidTransform.identity())
    assert one.names == ("",)
    assert not one.covariance[13:].any()


@pytest.mark.parametrize("names", [(), ("a", "a")])
def test_a_rig_has_sensors_with_names_of_their_own(names):
    sensors = tuple(RigSensor(name, sensor(), RigidTransform.identity()) for name in names)
    with pytest.raises(ValueError, match="sensors must have a name each"):
        Rig(sensors, np.zeros((SIZE * len(names), SIZE * len(names))))
