"""A stripe that bends, blurred and located as in life, is put back where it was.

The blur is alike in all directions here; that of a thick sheet is shown on rendered wheels.
"""

import numpy as np
import pytest
import wheel_stripes as ws

from calib import locate_stripe
from measure.laying.bend import bend_px


def ring(radius_px, width_px, rng, size=320):
    """A picture of a ring whose line is a perfect Gaussian blur of an infinitely thin one."""
    v, u = np.mgrid[:size, :size] - (size - 1) / 2.0 + 0.21
    angle = np.linspace(0.0, 2.0 * np.pi, 4 * int(radius_px), endpoint=False)
    light = np.zeros((size, size))
    for a in angle:
        off = (u - radius_px * np.cos(a)) ** 2 + (v - radius_px * np.sin(a)) ** 2
        light += np.exp(-0.5 * off / width_px**2)
    counts = 10.0 + 160.0 * light / light.max() + rng.normal(0.0, 0.5, light.shape)
    return np.clip(np.round(counts), 0, 255).astype(np.uint8)


def radii(stripe, centre_px, size=320):
    return np.hypot(*(centre_px - (size - 1) / 2.0 + 0.21).T)


@pytest.mark.parametrize("radius_px", [25.0, 60.0])
def test_a_blurred_ring_gets_its_radius_back(radius_px, rng):
    stripe = locate_stripe(ring(radius_px, 1.3, rng))
    raw = radii(stripe, stripe.centre_px) - radius_px
    straight = stripe.centre_px - bend_px(stripe)[:, None] * stripe.normal
    rest = radii(stripe, straight) - radius_px
    on_ring = np.abs(raw) < 1.0
    # Blur and kernel, 1.3 and 1.5 px, draw the ring in by (1.3^2 + 1.5^2) / 2R.
    assert np.median(raw[on_ring]) == pytest.approx(-1.97 / radius_px, rel=0.35)
    assert abs(np.median(rest[on_ring])) < 0.35 * abs(np.median(raw[on_ring]))


def test_a_straight_stripe_is_left_alone(rng):
    u = np.arange(0.0, 600.0)
    centre = np.column_stack([u, 300.0 + 0.2 * u + rng.normal(0.0, 0.03, len(u))])
    normal = np.tile(np.array([-0.2, 1.0]) / np.hypot(0.2, 1.0), (len(u), 1))
    # 21 points of 0.03 px fix the curvature to 3e-4 / px: 6e-4 px here.
    assert np.abs(bend_px(ws.make_stripe(centre, normal))).max() < 4e-3


def test_few_points_are_left_alone():
    few = ws.make_stripe(np.array([[1.0, 1.0], [2.0, 1.0]]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert (bend_px(few) == 0.0).all()
