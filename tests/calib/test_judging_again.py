"""Calibrating again from fewer views: is the scatter the predicted one, and is a bad pose found?"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import LED_TARGET, PAPER_CAMERA, PAPER_SENSOR, SIZE, setting

from calib import (
    Method,
    TooFewViews,
    judge_leaving_out,
    judge_repeatability,
)

KNOWN = {"camera": PAPER_CAMERA, **SIZE}


@pytest.fixture
def views(rng):
    scene = setting(rng, 12, target=LED_TARGET)
    return scene.views(rng, dots_px=0.1, stripe_px=0.1)


def test_repeatability_scatters_as_the_covariance_expects(views, rng):
    answer = judge_repeatability(views, LED_TARGET, rng, **KNOWN, draws=20, take=6)
    assert answer.coefficients.shape == (20, 4)
    assert answer.refusals == ()
    # Of one set of 12 views the scatter has some ten degrees of freedom: within 22 %, twice.
    assert answer.sheet_spread_mm == pytest.approx(answer.expected_spread_mm, rel=0.5)
    assert (answer.spread > 0.0).all()
    truth = PAPER_SENSOR.plane.coefficients
    assert np.abs(answer.mean - truth)[3] < 6.0 * answer.spread[3]


def test_same_draws_give_the_same_answer(views):
    first, second = (
        judge_repeatability(
            views,
            LED_TARGET,
            np.random.default_rng(7),
            **KNOWN,
            method=Method.PREPLANAR,
            draws=3,
            take=6,
        )
        for _ in range(2)
    )
    np.testing.assert_array_equal(first.coefficients, second.coefficients)


def test_more_pictures_than_there_are_cannot_be_drawn(views, rng):
    with pytest.raises(TooFewViews, match="12 pictures"):
        judge_repeatability(views, LED_TARGET, rng, **KNOWN, take=13)


def test_views_without_a_stripe_are_not_drawn(views, rng):
    bare = [replace(view, stripe=None) for view in views[:8]]
    with pytest.raises(TooFewViews, match="4 pictures"):
        judge_repeatability([*bare, *views[8:]], LED_TARGET, rng, **KNOWN, take=5)


@pytest.mark.parametrize("wrong", [{"draws": 1}, {"take": 1}])
def test_one_draw_tells_no_scatter(views, rng, wrong):
    with pytest.raises(ValueError, match="at least 2"):
        judge_repeatability(views, LED_TARGET, rng, **KNOWN, **wrong)


def test_parts_that_cannot_be_solved_are_counted(views, rng):
    same = [views[0]] * 6 + views[1:2]
    with pytest.raises(TooFewViews, match="could be solved"):
        judge_repeatability(same, LED_TARGET, rng, **KNOWN, draws=3, take=2)


def test_left_out_pose_that_is_off_is_off_by_what_its_stripe_is(views):
    shifted = views[3].stripe
    moved = replace(shifted, centre_px=shifted.centre_px + 3.0 * shifted.normal)
    poses = judge_leaving_out(
        [*views[:3], replace(views[3], stripe=moved), *views[4:]], LED_TARGET, **KNOWN
    )
    assert [pose.reason for pose in poses] == [""] * 12
    worst = max(poses, key=lambda pose: pose.rms_mm)
    assert worst.name == views[3].name
    assert abs(worst.mean_mm) > 0.9 * worst.rms_mm
    # A pixel along the ray is worth at least its width on the sheet: a third of a millimetre.
    assert worst.rms_mm > 3.0 * 0.15


def test_left_out_poses_of_exact_views_are_exact(rng):
    scene = setting(rng, 5, target=LED_TARGET)
    exact = [scene.clean_view(index, 20) for index in range(5)]
    for pose in judge_leaving_out(exact, LED_TARGET, **KNOWN):
        assert pose.rms_mm < 1e-3


def test_view_without_stripe_is_named_not_judged(views):
    poses = judge_leaving_out([replace(views[0], stripe=None), *views[1:4]], LED_TARGET, **KNOWN)
    assert "stripe" in poses[0].reason
    assert np.isnan(poses[0].rms_mm)
    assert np.isnan(poses[0].mean_mm)


def test_pose_whose_others_do_not_suffice_says_why(views):
    poses = judge_leaving_out(views[:2], LED_TARGET, **KNOWN)
    assert all("at least 2" in pose.reason for pose in poses)
