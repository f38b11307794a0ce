"""Are crossings of stripe and grid measured and gauged where they truly are?

Views are made from known truth (`synthetic_views`); nothing is told here of pictures.
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import LED_TARGET, PAPER_SENSOR, noisy, setting

from calib import LaserSensor, LightPlane, RigidTransform, Target, judge_distances
from calib.homography import apply_homography
from calib.judging.crossings import board_homography, grid_crossings

DISCS = Target.parse("dots:7x8:12:d=6")


def view_of(rng, target=LED_TARGET, turn_rad=0.0):
    scene = setting(rng, 1, target=target)
    if turn_rad:
        middle = np.append(target.points_mm.mean(axis=0)[:2], 0.0)
        turn = RigidTransform.from_rotation_vector([0.0, 0.0, turn_rad], np.zeros(3))
        about = RigidTransform(turn.rotation, middle - turn.rotation @ middle)
        scene = replace(scene, poses=(scene.poses[0] @ about,))
    return scene.clean_view(0, 60), scene.poses[0]


def test_true_sensor_measures_what_the_target_gauges(rng):
    view, _ = view_of(rng)
    (placement,) = judge_distances([view], LED_TARGET, PAPER_SENSOR)
    assert placement.reason == ""
    assert len(placement.errors_mm) >= 3
    assert placement.gauged_mm.min() >= LED_TARGET.pitch_mm
    # Noise-free points; the homography is solved to 1e-8 of the target.
    np.testing.assert_allclose(placement.measured_mm, placement.gauged_mm, atol=1e-4)


def test_crossings_lie_on_sheet_and_board_alike(rng):
    view, pose = view_of(rng)
    crossings = grid_crossings(view, LED_TARGET, PAPER_SENSOR.camera)
    flat = np.column_stack([crossings.board_mm, np.zeros(len(crossings))])
    in_cam = pose.apply(flat)
    np.testing.assert_allclose(PAPER_SENSOR.plane.distance_mm(in_cam), 0.0, atol=1e-4)
    np.testing.assert_allclose(in_cam / in_cam[:, 2:], crossings.rays_in_cam, atol=1e-7)


def test_stripe_along_the_columns_is_judged_by_rows(rng):
    view, _ = view_of(rng, turn_rad=np.pi / 2.0)
    (placement,) = judge_distances([view], LED_TARGET, PAPER_SENSOR)
    assert placement.lines == "rows"
    np.testing.assert_allclose(placement.errors_mm, 0.0, atol=1e-4)


def test_homography_is_free_of_the_shift_of_disc_centroids(rng):
    view, pose = view_of(rng, DISCS)
    sensed = board_homography(view, DISCS, PAPER_SENSOR.camera)
    true = pose.apply(DISCS.points_mm)
    seen = apply_homography(sensed, DISCS.points_mm[:, :2])
    # The shift is some 0.05 px, 2e-5 of the focal length; a hundredth of it may stay.
    np.testing.assert_allclose(seen, true[:, :2] / true[:, 2:], atol=3e-7)


def test_a_radius_as_seen_serves_where_the_target_tells_none(rng):
    view, _ = view_of(rng, DISCS)
    untold = replace(DISCS, diameter_mm=None)
    seen = replace(view, dot_radius=0.5 * DISCS.diameter_mm / DISCS.pitch_mm)
    told = board_homography(view, DISCS, PAPER_SENSOR.camera)
    np.testing.assert_array_equal(board_homography(seen, untold, PAPER_SENSOR.camera), told)


def test_one_displaced_dot_moves_no_distance(rng):
    view, _ = view_of(rng)
    quiet = noisy(view, rng, 0.02, 0.02)
    centre = quiet.points.centre_px.copy()
    centre[10] += [3.0, -2.0]
    worse = replace(quiet, points=replace(quiet.points, centre_px=centre))
    before, after = judge_distances([quiet, worse], LED_TARGET, PAPER_SENSOR)
    # A dot's noise of 0.02 px is 0.005 mm here; the false one weighs less than that.
    np.testing.assert_allclose(after.errors_mm, before.errors_mm, atol=0.005)


def test_sheet_that_is_off_shows_in_the_distances(rng):
    view, _ = view_of(rng)
    a, b, c, d = PAPER_SENSOR.plane.coefficients
    off = LaserSensor.exact(PAPER_SENSOR.camera, LightPlane.from_coefficients([a, b, c, 1.002 * d]))
    (placement,) = judge_distances([view], LED_TARGET, off)
    # A sheet scaled about the camera's centre scales every distance alike.
    np.testing.assert_allclose(placement.measured_mm / placement.gauged_mm, 1.002, rtol=1e-6)


def test_stripe_of_another_sheet_is_named_and_not_measured(rng):
    view, _ = view_of(rng)
    moved = replace(view.stripe, centre_px=view.stripe.centre_px + 80.0 * view.stripe.normal)
    (placement,) = judge_distances([replace(view, stripe=moved)], LED_TARGET, PAPER_SENSOR)
    assert "off the sheet" in placement.reason
    assert len(placement.errors_mm) == 0


def test_view_without_a_stripe_says_so(rng):
    view, _ = view_of(rng)
    (placement,) = judge_distances([replace(view, stripe=None)], LED_TARGET, PAPER_SENSOR)
    assert "stripe" in placement.reason


def test_stripe_over_one_column_is_too_short(rng):
    view, _ = view_of(rng)
    short = replace(view, stripe=view.stripe.select(np.arange(6)))
    (placement,) = judge_distances([short], LED_TARGET, PAPER_SENSOR)
    assert "2 are needed" in placement.reason


def test_crossings_of_a_view_without_a_stripe_are_refused(rng):
    view, _ = view_of(rng)
    with pytest.raises(ValueError, match="no stripe"):
        grid_crossings(replace(view, stripe=None), LED_TARGET, PAPER_SENSOR.camera)
