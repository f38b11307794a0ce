"""Where dots are so noisy that a board's tilt is hardly known: true stripes stay, false ones go."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import PAPER_CAMERA, PAPER_TARGET, SIZE, setting

import calib.solving.joint.method as joint
from calib import calibrate

STRIPE_PX = 0.5


def drawn(seed, dots_px):
    rng = np.random.default_rng([seed, 7])
    place = setting(rng, 10, target=PAPER_TARGET)
    return place.views(rng, dots_px=dots_px, stripe_px=STRIPE_PX, stripe_count=10)


def stripes_left_out(views):
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA)
    return [view.name for view in found.views if not view.stripe.used.any()]


# Of 30 pose sets at 8 px, these lost a true stripe for want of a second look.
HARD = (4, 9, 21, 26)


def test_true_stripes_are_kept_at_large_dot_noise():
    # Chance leaves out one in 300,000.
    assert [seed for seed in (*HARD, *range(3)) if stripes_left_out(drawn(seed, 8.0))] == []


def test_without_a_second_look_the_same_stripes_are_left_out(monkeypatch):
    monkeypatch.setattr(joint, "acquitted", lambda problem, solution, doubted: doubted & False)
    assert all(stripes_left_out(drawn(seed, 8.0)) for seed in HARD)


@pytest.mark.parametrize(("dots_px", "shift_px"), [(0.1, 5.0), (2.0, 30.0), (5.0, 80.0)])
def test_a_false_stripe_is_left_out_at_any_dot_noise(dots_px, shift_px):
    for seed in range(5):
        views = drawn(seed, dots_px)
        stripe = views[2].stripe
        moved = replace(stripe, centre_px=stripe.centre_px + shift_px * stripe.normal)
        views[2] = replace(views[2], stripe=moved)
        assert stripes_left_out(views) == [views[2].name], seed
