"""Does each light do to the picture what its name says?  Not how well it can be measured."""

import numpy as np
import pytest

from station.scenes import Light, TargetScene, pose_through_dots, target_poses, target_scenes
from station.scenes.crossing import crossing_on_board


@pytest.fixture(scope="module")
def pose(sensor, target):
    return target_poses(np.random.default_rng(11), 1, sensor, target)[0]


@pytest.fixture(scope="module")
def pictures(sensor, target, pose):
    return {
        light: TargetScene(sensor, target, pose, light, seed=2).render(np.random.default_rng(3))
        for light in Light
    }


def levels(sensor, pose, picture, places_mm):
    """Levels of the picture at places on the board, shape (N, 2)."""
    points = pose.apply(np.column_stack([places_mm, np.zeros(len(places_mm))]))
    u, v = np.rint(sensor.camera.project(points)).astype(int).T
    return picture[v, u].astype(float)


@pytest.fixture(scope="module")
def free(sensor, target, pose):
    """Dots that the stripe leaves alone, and the middles between dots that it does, (N, 2)."""
    crossing = crossing_on_board(sensor.plane, pose, np.array([42.0, 36.0]))
    beside = np.array([-crossing.direction[1], crossing.direction[0]])
    dots = target.points_mm[:, :2]
    middles = dots[dots[:, 0] < 84.0] + [6.0, 0.0]
    return tuple(
        places[np.abs((places - crossing.nearest_mm) @ beside) > 6.0] for places in (dots, middles)
    )


def stripe_levels(sensor, pose, picture):
    crossing = crossing_on_board(sensor.plane, pose, np.array([42.0, 36.0]))
    along = np.linspace(-40.0, 40.0, 200)[:, None]
    on_board = crossing.nearest_mm + along * crossing.direction
    far = np.linalg.norm(on_board - np.rint(on_board / 12.0) * 12.0, axis=1) > 4.5
    return levels(sensor, pose, picture, on_board[far])


def test_good_light_clips_neither_dots_nor_stripe(sensor, pose, pictures, free):
    dots, metal = (levels(sensor, pose, pictures[Light.GOOD], places) for places in free)
    assert dots.max() < 230
    assert dots.min() > 5.0 * metal.max()
    stripe = stripe_levels(sensor, pose, pictures[Light.GOOD])
    assert np.median(stripe) > 55
    assert (stripe == 255).mean() < 0.02


def test_reflection_brightens_part_of_the_metal(sensor, pose, pictures, free):
    metal = levels(sensor, pose, pictures[Light.REFLECTION], free[1])
    assert metal.max() > 100
    assert np.median(metal) < 60


def test_over_exposure_clips_dots_stripe_and_some_metal(sensor, pose, pictures, free):
    dots, metal = (levels(sensor, pose, pictures[Light.OVER_EXPOSED], places) for places in free)
    assert (dots >= 250).all()
    assert (stripe_levels(sensor, pose, pictures[Light.OVER_EXPOSED]) >= 250).mean() > 0.7
    assert 0.02 < (metal >= 250).mean() < 0.6


def test_dim_light_leaves_a_tenth_and_unevenly(sensor, pose, pictures, free):
    dim = levels(sensor, pose, pictures[Light.DIM], free[0]) - 3.0
    good = levels(sensor, pose, pictures[Light.GOOD], free[0]) - 3.0
    assert 0.04 < np.median(dim / good) < 0.16
    assert dim.max() > 1.6 * dim.min()


def test_stray_light_clips_the_stripe_and_adds_a_false_one(sensor, target, pose):
    scene = TargetScene(sensor, target, pose, Light.STRAY, seed=2)
    picture = scene.render(np.random.default_rng(3))
    assert (stripe_levels(sensor, pose, picture) >= 250).mean() > 0.7
    # Going down each column of dots halfway between two, two clipped stripes are met.
    rows = np.linspace(-9.0, 81.0, 2000)
    counts = []
    for col in range(7):
        place = np.column_stack([np.full(rows.size, 12.0 * col + 6.0), rows])
        clipped = levels(sensor, pose, picture, place) >= 250
        counts.append(int((np.diff(clipped.astype(int)) == 1).sum()))
    assert np.median(counts) >= 2


def test_bright_background_outshines_the_metal_and_lowers_the_contrast(
    sensor, pose, pictures, free
):
    picture = pictures[Light.BRIGHT_BACKGROUND]
    dots, metal = (levels(sensor, pose, picture, places) for places in free)
    assert np.median(dots) < 8.0 * np.median(metal)
    assert np.median(picture) > np.median(metal)
    edge = np.concatenate([picture[:40].ravel(), picture[-40:].ravel()]).astype(float)
    assert edge.std() > 20


def test_crossing_scene_has_the_stripe_through_most_dots_of_a_row(sensor, target, rng):
    (scene,) = target_scenes(rng, sensor, target, [Light.CROSSING])
    crossing = crossing_on_board(sensor.plane, scene.cam_from_board, np.array([42.0, 36.0]))
    beside = np.array([-crossing.direction[1], crossing.direction[0]])
    row = target.points_mm[3 * 8 : 4 * 8, :2]
    distance = np.abs((row - crossing.nearest_mm) @ beside)
    assert (distance < 3.0).sum() >= 6
    dots = levels(sensor, scene.cam_from_board, scene.render(rng), row[distance < 0.5])
    assert (dots >= 250).all()


def test_pose_through_dots_keeps_the_plane_of_the_board(sensor, target, pose):
    moved = pose_through_dots(sensor, target, pose)
    np.testing.assert_allclose(moved.rotation[:, 2], pose.rotation[:, 2], atol=1e-12)
    shift = moved.translation_mm - pose.translation_mm
    assert shift @ pose.rotation[:, 2] == pytest.approx(0.0, abs=1e-9)


def test_shorter_exposure_brings_an_over_exposed_target_back(sensor, target, pose, free):
    scene = TargetScene(sensor, target, pose, Light.OVER_EXPOSED, seed=2)
    picture = scene.render(np.random.default_rng(1), exposure=0.25)
    dots = levels(sensor, pose, picture, free[0])
    assert np.median(dots) < 200
