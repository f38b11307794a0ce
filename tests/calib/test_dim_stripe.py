"""A stripe that grows dim for a few pixels, as where light grazes a flange, is seen all along."""

import numpy as np

from calib import locate_stripe

WIDTH_PX, GROUND, DIM, BRIGHT = 1.1, 6.0, 10.0, 60.0


def test_a_stripe_that_grows_dim_for_ten_pixels_is_seen_there_too(rng):
    v, u = np.mgrid[0:1088, 0:2048].astype(np.float64)
    height = BRIGHT - (BRIGHT - DIM) * np.exp(-0.5 * ((v - 500.0) / 5.0) ** 2)
    centre = 913.0 + 0.25 * (v - 500.0)
    light = GROUND + height * np.exp(-0.5 * ((u - centre) / WIDTH_PX) ** 2)
    picture = np.clip(np.rint(light + rng.normal(0.0, 0.4, light.shape)), 0, 255).astype(np.uint8)
    found = locate_stripe(picture)
    u_found, v_found = found.centre_px.T
    dim = np.abs(v_found - 500.0) < 6.0
    # About a point a pixel of its length: 12 rows hold 12.4.
    assert dim.sum() >= 10
    off = (u_found - 913.0 - 0.25 * (v_found - 500.0))[dim] / np.hypot(1.0, 0.25)
    # Noise of 0.4 on a height of 10 leaves 0.05 px.
    assert np.abs(off).max() < 0.2
