"""Does the stripe on a piece lie on its profile, and only where laser and camera reach?"""

from dataclasses import replace

import numpy as np
import pytest

from measure import Piece
from station.scenes import PieceScene, piece_pose, projector_in_cam_mm
from station.scenes.prism import Prism

RIDGES = Piece.from_corners("ridges", "", [[(0, 0)], [(30, 0)], [(40, 10)], [(70, 10)]])
HILL = Piece.from_corners("hill", "", [[(-25, 0)], [(0, 15), (25, 0)]])
STEP = Piece.step(10.0, width_mm=30.0)


def pixels_of(scene, first=3.0, spare=3.0):
    """Where the middle parts of the sides are seen, one list a side."""
    for face in scene.piece.faces:
        along = np.arange(first, face.length_mm - spare, 0.1)
        points, _ = face.points(along)
        in_piece = np.column_stack([points[:, 0], np.zeros(len(points)), points[:, 1]])
        yield scene.sensor.camera.project(scene.cam_from_piece.apply(in_piece))


def stripe_light(scene):
    return scene.light_counts() - replace(scene, laser_on=False).light_counts()


@pytest.mark.parametrize("piece", [RIDGES, HILL])
def test_stripe_lies_on_the_profile(sensor, clear, ridge_of, piece):
    pose = piece_pose(sensor, piece, middle_px=(1000.0, 560.0), turn_rad=0.1)
    scene = PieceScene(sensor, pose, piece, physics=clear)
    light = stripe_light(scene)
    for pixels, face in zip(pixels_of(scene), piece.faces, strict=True):
        ridge = ridge_of(light, pixels)
        place = pose.inverse().apply(sensor.locate(ridge))
        _, outside = face.place(place[:, [0, 2]])
        # Blur draws the ridge of a bent stripe inwards, on 25 mm by less than a hundredth.
        np.testing.assert_allclose(outside, 0.0, atol=0.02)


def test_the_wall_of_a_step_throws_a_shadow(sensor, clear):
    # At the left, turned right, the laser sees less behind the wall than the camera does.
    pose = piece_pose(sensor, STEP, middle_px=(350.0, 560.0), turn_rad=0.6)
    scene = PieceScene(sensor, pose, STEP, physics=clear)
    x, _, z = pose.inverse().apply(projector_in_cam_mm(sensor)[None])[0]
    edge_mm = -10.0 * x / (z - 10.0)
    low, wall, high = pixels_of(scene, first=0.5, spare=0.5)
    light = stripe_light(scene)
    lit = [light[tuple(np.rint(side).astype(int).T[::-1])] > 20.0 for side in (low, wall, high)]
    place_mm = np.arange(0.5, 29.5, 0.1) - 30.0
    # Blur and pixels soften the edge by 0.3 mm; the camera alone would see 1.2 mm more.
    assert place_mm[lit[0][: len(place_mm)]].max() == pytest.approx(edge_mm, abs=0.6)
    assert not lit[1].mean() > 0.2
    assert lit[2].mean() > 0.95


def test_light_from_the_side_reaches_what_no_face_hides():
    prism = Prism(STEP.faces, 40.0)
    x = np.arange(-29.5, 0.0, 1.0)
    low = np.column_stack([x, np.zeros_like(x), np.zeros_like(x)])
    # From 45 degrees on the high side the wall of 10 mm shades 10 mm.
    shaded = prism.shaded(np.array([1000.0, 0.0, 1010.0]), low)
    np.testing.assert_array_equal(shaded, x > -10.0)
    assert not prism.shaded(np.array([-1000.0, 0.0, 1000.0]), low).any()


def test_picture_shows_a_stripe_only_with_the_laser_on(sensor, rng):
    pose = piece_pose(sensor, RIDGES, middle_px=(1000.0, 560.0))
    scene = PieceScene(sensor, pose, RIDGES)
    dark = replace(scene, laser_on=False).render(np.random.default_rng(1))
    assert dark.max() < 60
    assert scene.render(rng).max() > 120


def test_a_slanted_piece_still_crosses_the_sheet_at_its_middle(sensor):
    pose = piece_pose(sensor, RIDGES, middle_px=(1000.0, 560.0), slant_rad=(0.05, 0.02))
    middle = RIDGES.corners_mm.mean(axis=0)
    at = pose.apply(np.array([[middle[0], 0.0, middle[1]]]))
    assert abs(float(sensor.plane.distance_mm(at)[0])) < 1e-9


@pytest.mark.parametrize("length", [0.0, -1.0, np.nan])
def test_a_piece_of_no_length_is_refused(sensor, length):
    pose = piece_pose(sensor, RIDGES, middle_px=(1000.0, 560.0))
    with pytest.raises(ValueError, match="length_mm"):
        PieceScene(sensor, pose, RIDGES, length_mm=length)
