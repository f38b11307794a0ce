"""Closed forms that a solve begins with: homography, pose, line, plane, cross-ratio, focal length.

They need not be exact on noisy points; on exact ones they are, and false points do not move them.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_views import PAPER_CAMERA, PAPER_TARGET, setting

from calib import Degenerate, RigidTransform
from calib.homography import (
    apply_homography,
    fit_homography,
    fit_homography_robustly,
    pose_from_homography,
)
from calib.lines import fit_line_robustly, fit_plane
from calib.solving.cross_ratio import place_by_cross_ratio
from calib.solving.start import start_plane
from calib.solving.zhang import camera_from_homographies

BOARD = PAPER_TARGET.points_mm
POSE = RigidTransform.from_rotation_vector([0.4, -0.3, 0.2], [-40.0, -30.0, 600.0])


def rays_of(pose):
    points = pose.apply(BOARD)
    return points[:, :2] / points[:, 2:]


def assert_same_pose(found, expected, atol):
    np.testing.assert_allclose(found.rotation, expected.rotation, atol=atol)
    np.testing.assert_allclose(found.translation_mm, expected.translation_mm, atol=1e3 * atol)


def test_homography_of_exact_points_holds_the_pose():
    homography = fit_homography(BOARD[:, :2], rays_of(POSE))
    np.testing.assert_allclose(
        apply_homography(homography, BOARD[:, :2]), rays_of(POSE), atol=1e-12
    )
    assert_same_pose(pose_from_homography(homography), POSE, 1e-9)


def test_homography_is_found_among_two_fifths_of_false_points(rng):
    seen = rays_of(POSE) + rng.normal(0.0, 1e-5, (100, 2))
    seen[:40] += [0.03, -0.02]  # as one, like a mirror image: the hardest kind
    homography = fit_homography_robustly(BOARD[:, :2], seen, 1e-5)
    assert_same_pose(pose_from_homography(homography), POSE, 2e-3)


def test_points_on_one_line_determine_no_homography():
    with pytest.raises(Degenerate, match="on one line"):
        fit_homography(BOARD[:10, :2], rays_of(POSE)[:10])


@given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0.0, 3.0), st.floats(300.0, 2e3))
def test_pose_comes_back_from_any_homography(tilt_x, tilt_y, turn, depth):
    pose = RigidTransform.from_rotation_vector([tilt_x, tilt_y, 0.0], [10.0, -20.0, depth])
    pose = pose @ RigidTransform.from_rotation_vector([0.0, 0.0, turn], [0.0, 0.0, 0.0])
    homography = np.column_stack([pose.rotation[:, :2], pose.translation_mm])
    assert_same_pose(pose_from_homography(0.01 * homography), pose, 1e-9)


def test_line_is_found_among_false_points(rng):
    x = np.linspace(-1.0, 1.0, 60)
    points = np.column_stack([x, 0.3 * x + 0.1 + rng.normal(0.0, 1e-4, 60)])
    points[:24, 1] += rng.uniform(0.05, 1.0, 24)
    line, agreeing = fit_line_robustly(points)
    assert not agreeing[:24].any()
    assert agreeing[24:].all()
    expected = np.array([0.3, -1.0, 0.1]) / np.hypot(0.3, 1.0)
    np.testing.assert_allclose(line * np.sign(line[0]), expected, atol=2e-4)


def test_plane_through_exact_points_is_exact(rng):
    normal = np.array([2.0, -1.0, 2.0]) / 3.0
    points = rng.normal(0.0, 50.0, (20, 3))
    points -= np.outer(points @ normal + 7.0, normal)
    plane = fit_plane(points)
    np.testing.assert_allclose(plane * np.sign(plane[0]), [*normal, 7.0], atol=1e-12)


def stripes_on_a_sheet(rng, count):
    """Ends of stripes, (M, 2, 3), on the sheet z = 500 of the camera frame."""
    ends = np.full((count, 2, 3), 500.0)
    ends[:, 0, 0], ends[:, 1, 0] = -50.0, 50.0
    ends[:, :, 1] = np.linspace(-60.0, 60.0, count)[:, None] + rng.normal(0.0, 5.0, (count, 2))
    return ends


def test_first_plane_survives_two_fifths_of_false_stripes(rng):
    ends = stripes_on_a_sheet(rng, 10)
    ends[:, :, 2] += rng.normal(0.0, 0.01, (10, 2))
    ends[[0, 3, 4, 8], :, 2] += rng.uniform(5.0, 60.0, (4, 1))
    first = start_plane(ends, np.tile(1e-4 * np.eye(3), (10, 1, 1)))
    assert not first.agreeing[[0, 3, 4, 8]].any()
    np.testing.assert_allclose(first.plane.coefficients, [0.0, 0.0, -1.0, 500.0], atol=0.05)


def test_stripes_that_spread_no_more_than_their_poses_noise_are_refused(rng):
    ends = stripes_on_a_sheet(rng, 10)
    ends[:, :, 1] *= 0.1
    wander = np.tile(4.0**2 * np.eye(3), (10, 1, 1))
    with pytest.raises(Degenerate, match="one line in space"):
        start_plane(ends, wander)
    assert start_plane(ends, wander * 1e-4).agreeing.all()


@given(
    st.lists(st.integers(0, 12), min_size=4, max_size=4, unique=True),
    st.floats(-0.02, 0.02),
    st.floats(0.5, 3.0),
)
def test_cross_ratio_finds_the_place_under_any_projection(places, perspective, scale):
    places = np.array(places, dtype=float)
    seen = scale * places / (1.0 + perspective * places)
    found = place_by_cross_ratio(places[:3], seen[:3], seen[3])
    assert found == pytest.approx(places[3], abs=1e-6)


@pytest.mark.parametrize("place", [0.0, 10.0, 30.0])
def test_cross_ratio_of_a_point_on_a_known_one_is_that_point(place):
    known = np.array([0.0, 10.0, 30.0])
    assert place_by_cross_ratio(known, known / (1 + known / 90), place / (1 + place / 90)) == (
        pytest.approx(place, abs=1e-9)
    )


def pixel_homographies(rng, count, noise_px=0.0):
    """Maps to pixels of a camera without distortion, its centre off the middle."""
    camera = PAPER_CAMERA.matrix
    camera[:2, 2] += [8.0, -5.0]
    for pose in setting(rng, count).poses:
        seen = apply_homography(camera, rays_of(pose))
        yield fit_homography(BOARD[:, :2], seen + rng.normal(0.0, noise_px, seen.shape))


def test_focal_length_comes_out_near_enough_to_start_from(rng):
    for noise_px in (0.0, 1.0):
        found = camera_from_homographies(
            list(pixel_homographies(rng, 8, noise_px)), width=2048, height=1088
        )
        # The principal point is taken at the middle; its 9 px and the noise cost some per cent.
        np.testing.assert_allclose(found[:2], 2181.0, rtol=0.1)
        np.testing.assert_array_equal(found[4:], 0.0)
