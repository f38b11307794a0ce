"""Dots without an edge: how soft they are is told, and their light is parted and taken off.

Bells of light from arithmetic; of lamps that exist, and of bells that reach half over their
neighbours, the tests say nothing.
"""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from calib import Target, observe_target
from calib.seeing import disc
from calib.seeing.dots_soft import (
    SOFT_FROM_PX,
    blur_px,
    edge_reach_px,
    light_over_outline,
    without_dots,
)
from calib.seeing.ellipse import Ellipses

TARGET = Target.parse("dots:5x6:10")
PITCH_PX, BELL_PX, GROUND, HEIGHT, READ = 60.0, 9.0, 20.0, 150.0, 1.5
SHAPE = (440, 500)
V, U = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(float)


def places(rng):
    row, col = np.divmod(np.arange(30), 6)
    return np.column_stack([90.0 + PITCH_PX * col, 90.0 + PITCH_PX * row]) + rng.uniform(0, 1, 2)


def bells(centres):
    square = (U - centres[:, 0, None, None]) ** 2 + (V - centres[:, 1, None, None]) ** 2
    return HEIGHT * np.exp(-0.5 * square / BELL_PX**2).sum(axis=0)


def exposed(light, rng):
    return np.clip(np.rint(light + READ * rng.standard_normal(SHAPE)), 0, 255).astype(np.uint8)


def test_bells_of_light_have_their_centres_where_they_are(rng):
    centres = places(rng)
    view = observe_target(exposed(GROUND + bells(centres), rng), TARGET, name="bells")
    order = view.points.row * 6 + view.points.col
    off = view.points.centre_px - centres[order]
    turned = view.points.centre_px - centres[::-1][order]
    off = min(off, turned, key=lambda each: np.abs(each).max())
    assert len(view.points) == 30
    # White noise leaves READ / (sqrt(pi) HEIGHT) = 0.006 px; a fit that knows neither height
    # nor ground beforehand some times that.
    assert np.sqrt(np.mean(off**2)) < 0.03
    # A height that may rise to one side makes of a bell on a slope a bell aside: 0.3 px.
    assert view.points.sigma_px.max() < 0.2


@pytest.mark.parametrize("true", [1.5, 3.0, 5.0])
def test_the_blur_of_discs_is_told(rng, true):
    centres = places(rng)
    square = (U - centres[:, 0, None, None]) ** 2 + (V - centres[:, 1, None, None]) ** 2
    light = GROUND + HEIGHT * gaussian_filter((square < 15.0**2).any(axis=0).astype(float), true)
    outlines = Ellipses.circles(centres, np.full(30, 15.0))
    # Samples are a twentieth of the radius apart and a fall is taken over three: 2 px of 15.
    assert blur_px(exposed(light, rng), outlines) == pytest.approx(true, rel=0.25)


def test_discs_count_as_soft_from_where_their_window_is_too_narrow():
    outlines = Ellipses.circles(np.array([[0.0, 0.0], [60.0, 0.0]]), np.full(2, 10.0))
    assert edge_reach_px(outlines, SOFT_FROM_PX) == pytest.approx(2.5 * SOFT_FROM_PX)
    assert edge_reach_px(outlines, 40.0) == pytest.approx(0.5 * 60.0 - 10.0)


def discs(blur):
    parameters = disc.start(Ellipses.circles(np.zeros((3, 2)), np.full(3, 10.0)), np.zeros(2), blur)
    parameters[:, disc.HEIGHT] = HEIGHT
    return parameters


def test_only_a_bell_is_shifted_by_perspective_as_a_larger_disc_is():
    assert light_over_outline(discs(3.0)) == 1.0
    # A bell of sigma s is fitted as R = 0.79 s, blur 0.90 s, and its rings weigh by 2 s^2.
    bell = light_over_outline(discs(10.0 * 0.90 / 0.79))
    assert bell == pytest.approx(np.sqrt(2.0) / 0.79, rel=0.05)


def test_dots_taken_off_leave_the_ground_and_what_is_clipped():
    parameters = disc.start(
        Ellipses.circles(np.array([[100.0, 90.0]]), np.array([12.0])), np.array([[100, 90]]), 3.0
    )
    parameters[:, disc.HEIGHT] = HEIGHT
    offset = np.column_stack([U.ravel() - 100.0, V.ravel() - 90.0])
    light = disc.evaluate(parameters, offset)[0].reshape(SHAPE)
    picture = np.rint(GROUND + light).astype(np.uint8)
    picture[90, 100] = 255
    left = without_dots(picture, parameters, np.array([[100, 90]]))
    assert left[90, 100] == 255
    left[90, 100] = GROUND
    np.testing.assert_allclose(left, GROUND, atol=1)
