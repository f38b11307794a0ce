"""Are the dots and the stripe of a rendered target where geometry says?  Without noise."""

from dataclasses import replace

import numpy as np
import pytest

from calib import RigidTransform, Target
from station.scenes import Light, TargetScene, target_poses
from station.scenes.crossing import crossing_on_board


def projected_disc_centroid(camera, cam_from_board, centre_mm, radius_mm):
    """Centroid of the picture of a disc whose light falls by a tenth to its edge."""
    radius, angle = np.meshgrid(
        np.sqrt((np.arange(60) + 0.5) / 60) * radius_mm,
        (np.arange(120) + 0.5) / 120 * 2.0 * np.pi,
        indexing="ij",
    )
    place = centre_mm + np.column_stack([
        (radius * np.cos(angle)).ravel(),
        (radius * np.sin(angle)).ravel(),
        np.zeros(radius.size),
    ])

    def project(shift):
        return camera.project(cam_from_board.apply(place + shift))

    step = 1e-3
    along_x = project([step, 0.0, 0.0]) - project([-step, 0.0, 0.0])
    along_y = project([0.0, step, 0.0]) - project([0.0, -step, 0.0])
    area = np.abs(along_x[:, 0] * along_y[:, 1] - along_x[:, 1] * along_y[:, 0])
    weight = area * (1.0 - 0.1 * (radius.ravel() / radius_mm) ** 2)
    return (project([0.0, 0.0, 0.0]) * weight[:, None]).sum(axis=0) / weight.sum()


def seen_centroid(light, near_px, half_px=24):
    u, v = np.rint(near_px).astype(int)
    rows, columns = np.mgrid[-half_px : half_px + 1, -half_px : half_px + 1]
    patch = light[v - half_px : v + half_px + 1, u - half_px : u + half_px + 1].astype(float)
    # The metal around the dot is even under these physics.
    weight = (patch - np.median(patch[[0, -1]])) * (np.hypot(rows, columns) < half_px)
    return np.array([u + (weight * columns).sum() / weight.sum(),
                     v + (weight * rows).sum() / weight.sum()])  # fmt: skip


def test_dots_lie_on_the_centroids_of_their_projected_discs(sensor, target, clear, rng):
    off_px, centre_off_px = [], []
    for pose in target_poses(rng, 3, sensor, target):
        light = TargetScene(sensor, target, pose, laser_on=False, physics=clear).light_counts()
        for centre_mm in target.points_mm:
            expected = projected_disc_centroid(sensor.camera, pose, centre_mm, 3.0)
            seen = seen_centroid(light, expected)
            off_px.append(np.abs(seen - expected).max())
            centre_off_px.append(seen - sensor.camera.project(pose.apply(centre_mm[None]))[0])
    # Measured: 0.0015 px at most, from the straight edges that stand for round ones.
    assert max(off_px) < 0.005
    # The centre of the disc is another point: the eccentricity is in the picture.
    assert np.abs(centre_off_px).max() > 0.02


def test_stripe_lies_on_the_projected_crossing_of_sheet_and_board(sensor, target, clear, rng):
    for pose in target_poses(rng, 3, sensor, target):
        scene = TargetScene(sensor, target, pose, physics=clear)
        light = scene.light_counts() - replace(scene, laser_on=False).light_counts()
        crossing = crossing_on_board(sensor.plane, pose, np.array([42.0, 36.0]))
        along = np.linspace(-60.0, 60.0, 4001)[:, None]
        on_board = crossing.nearest_mm + along * crossing.direction
        on_picture = sensor.camera.project(
            pose.apply(np.column_stack([on_board, np.zeros(len(on_board))]))
        )
        to_dot = np.linalg.norm(on_board - np.rint(on_board / 12.0) * 12.0, axis=1)
        for place in np.flatnonzero((to_dot > 4.5) & (np.abs(on_board[:, 0] - 42.0) < 49.0))[::40]:
            u = int(round(on_picture[place, 0]))
            expected = np.interp(u, on_picture[:, 0], on_picture[:, 1])
            rows = int(round(expected)) + np.arange(-9, 10)
            column = light[rows, u].astype(float)
            # Measured: 0.006 px at most, where the stripe is broad and the board slants.
            assert (column * rows).sum() / column.sum() == pytest.approx(expected, abs=0.02)


def test_chessboard_corners_lie_between_four_squares(sensor, clear, rng):
    target = Target.parse("chessboard:6x8:10")
    (pose,) = target_poses(rng, 1, sensor, target)
    light = TargetScene(sensor, target, pose, laser_on=False, physics=clear).light_counts()
    around = 2.5 * np.array([[1, 1, 0], [-1, -1, 0], [1, -1, 0], [-1, 1, 0]])
    for corner in target.points_mm:
        u, v = np.rint(sensor.camera.project(pose.apply(corner + around))).astype(int).T
        same_1, same_2, other_1, other_2 = light[v, u]
        assert abs(same_1 - same_2) < 0.1 * max(same_1, other_1)
        assert max(same_1, other_1) > 3.0 * min(same_2, other_2)


def test_printed_dots_are_darker_than_their_ground(sensor, clear, rng):
    target = Target.parse("dots:7x8:12:dark:d=6")
    (pose,) = target_poses(rng, 1, sensor, target)
    light = TargetScene(sensor, target, pose, laser_on=False, physics=clear).light_counts()
    places = [target.points_mm, target.points_mm + [6.0, 0.0, 0.0]]
    dot, ground = (
        light[tuple(np.rint(sensor.camera.project(pose.apply(p))).astype(int).T[::-1])]
        for p in places
    )
    assert dot.max() < 0.3 * ground.min()


def test_laser_off_leaves_everything_but_the_stripe(sensor, target, rng):
    (pose,) = target_poses(rng, 1, sensor, target)
    scene = TargetScene(sensor, target, pose, Light.REFLECTION, seed=4)
    difference = scene.light_counts() - replace(scene, laser_on=False).light_counts()
    assert difference.min() > -1e-2
    # The stripe is some 10 px wide over 600 px, its halo wider: a small part of the picture.
    assert 1e-4 < (difference > 20.0).mean() < 0.01


def test_the_same_seed_and_generator_give_the_same_picture(sensor, target, rng):
    (pose,) = target_poses(rng, 1, sensor, target)
    scene = TargetScene(sensor, target, pose, Light.STRAY, seed=9)
    pictures = [scene.render(np.random.default_rng(1)) for _ in range(2)]
    np.testing.assert_array_equal(*pictures)
    assert pictures[0].dtype == np.uint8
    assert pictures[0].shape == (1088, 2048)
    other = replace(scene, seed=10).render(np.random.default_rng(1))
    assert (other != pictures[0]).mean() > 0.1


def test_board_that_shows_its_back_is_refused(sensor, target):
    turned = RigidTransform.from_rotation_vector([0.0, np.pi, 0.0], [0.0, 0.0, 500.0])
    with pytest.raises(ValueError, match="face it"):
        TargetScene(sensor, target, turned)


def test_board_behind_the_camera_is_refused(sensor, target):
    behind = RigidTransform(np.eye(3), np.array([0.0, 0.0, -500.0]))
    with pytest.raises(ValueError, match="before the camera"):
        TargetScene(sensor, target, behind)


def test_board_out_of_view_leaves_only_the_surroundings(sensor, target, rng):
    aside = RigidTransform(np.eye(3), np.array([900.0, 0.0, 500.0]))
    picture = TargetScene(sensor, target, aside).render(rng)
    assert picture.max() < 40
