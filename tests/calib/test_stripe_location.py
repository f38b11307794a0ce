"""Where the stripe is found, and how well its sigma tells how well.

A Gaussian stripe, averaged over pixels, with noise, saturation and a sloping ground. They say
nothing of speckle, nor of what of many lines is the stripe.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr

from calib import PixelNoise, locate_stripe
from calib.seeing.stripe import kernel_of

SHAPE = (320, 1300)
U = np.arange(SHAPE[1], dtype=float)
STRAIGHT = 90.0 + 0.113 * U


def stripe_light(centre_v, *, width=2.0, height=150.0, ground=10.0, slope=0.0, shape=SHAPE):
    """Return a stripe, `width` across itself, whose centre in each column is known."""
    steep = np.sqrt(1.0 + np.gradient(centre_v) ** 2)
    v = np.arange(shape[0])[:, None]
    s = width * steep
    bell = (
        (ndtr((v + 0.5 - centre_v) / s) - ndtr((v - 0.5 - centre_v) / s)) * s * np.sqrt(2 * np.pi)
    )
    return height * bell + ground + slope * (v - centre_v)


def exposed(light, rng, read=2.0, gain=0.0):
    noisy = light + rng.normal(size=light.shape) * np.sqrt(read**2 + gain * np.maximum(light, 0.0))
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def error_px(points, centre_v):
    """Return how far points are from the curve, across it."""
    u, v = points.centre_px.T
    steep = np.interp(u, U, np.gradient(centre_v))
    return (v - np.interp(u, U, centre_v)) / np.sqrt(1.0 + steep**2)


@pytest.mark.parametrize(
    ("width", "height", "read", "gain"),
    [(1.5, 60.0, 3.0, 0.0), (2.0, 150.0, 2.0, 0.0), (2.0, 150.0, 1.0, 0.1), (3.5, 25.0, 2.0, 0.0)],
)
def test_centres_are_unbiased_and_scatter_by_their_sigma(rng, width, height, read, gain):
    picture = exposed(stripe_light(STRAIGHT, width=width, height=height), rng, read, gain)
    points = locate_stripe(picture)
    error = error_px(points, STRAIGHT)
    # Neighbours share noise: of 1300 points about 1300 / (2 sqrt(pi) kernel) are independent.
    independent = 1300.0 / (3.5 * kernel_of(np.array([width]))[0])
    assert abs(error.mean()) < 4.0 * points.sigma_px.mean() / np.sqrt(independent)
    # That many draws pin a standard deviation to 6 to 8 %, and the noise told from the picture
    # is good to 5 %.
    assert (error / points.sigma_px).std() == pytest.approx(1.0, abs=0.2)
    assert len(points) == pytest.approx(1300, rel=0.03)


@pytest.mark.slow
def test_sigma_is_true_within_a_tenth_over_many_pictures(rng):
    light = stripe_light(STRAIGHT)
    whitened = []
    for _ in range(20):
        points = locate_stripe(exposed(light, rng))
        whitened.append(error_px(points, STRAIGHT) / points.sigma_px)
    assert np.concatenate(whitened).std() == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(("width", "height"), [(2.0, 700.0), (4.0, 1500.0), (2.5, 4500.0)])
def test_an_over_exposed_stripe_is_flagged_and_not_biased(rng, width, height):
    picture = exposed(stripe_light(STRAIGHT, width=width, height=height), rng, 1.0, 0.05)
    points = locate_stripe(picture)
    error = error_px(points, STRAIGHT)
    assert points.saturated.all()
    assert len(points) > 1200
    # Measured 0.0005 px; a pixel of sampling of the clipped edge may add some thousandths.
    assert abs(error.mean()) < 0.003
    assert np.abs(error).max() < 0.05
    assert (error / points.sigma_px).std() < 1.5


@pytest.mark.parametrize("slope", [-0.8, 0.4, 1.2])
def test_a_sloping_ground_does_not_draw_the_stripe_to_its_bright_side(slope):
    # Left alone, the slope would move the top by slope (σg² + σw²)^1.5 / (M σw): 0.08 px at 1.
    light = stripe_light(STRAIGHT, ground=120.0, slope=slope, height=100.0)
    near = np.abs(np.arange(SHAPE[0])[:, None] - STRAIGHT) < 60.0
    picture = exposed(np.where(near, light, 120.0), np.random.default_rng(1), read=0.5)
    points = locate_stripe(picture)
    error = error_px(points, STRAIGHT)
    on_stripe = np.abs(error) < 3.0
    assert on_stripe.sum() > 1200
    assert abs(error[on_stripe].mean()) < 0.003


def test_the_rim_of_a_clipped_reflection_is_no_stripe(rng):
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    light = 12.0 + 600.0 * np.exp(-0.5 * np.hypot(v - 160.0, u - 600.0) ** 2 / 40.0**2)
    assert len(locate_stripe(exposed(light, rng, gain=0.05))) == 0


def test_a_stripe_into_a_clipped_reflection_is_given_as_far_as_it_is_true(rng):
    v, u = np.mgrid[: SHAPE[0], : SHAPE[1]]
    squared = (v - 150.0) ** 2 + (u - 600.0) ** 2
    glare = 600.0 * np.exp(-0.5 * squared / 30.0**2) + 40.0 * np.exp(-0.5 * squared / 300.0**2)
    points = locate_stripe(exposed(stripe_light(STRAIGHT) + glare, rng, gain=0.05))
    error = error_px(points, STRAIGHT)
    # Up to the rim of the core the sensor clips the stripe; beyond, it hides it: 2 x 50 px.
    assert points.saturated.sum() > 20
    assert len(points) == pytest.approx(1300 - 100, abs=50)
    # Nearest the core a centre is off by some 0.03 px; 4 sigmas of 0.013 px at most elsewhere.
    assert np.abs(error).max() < 0.08
    assert np.abs(error / points.sigma_px).max() < 5.0


def test_where_a_step_of_the_ground_is_too_near_no_centre_is_given(rng):
    # The step moves the centres by up to 0.3 px, for it looks like a slope.
    step = np.where(np.arange(SHAPE[0])[:, None] < STRAIGHT - 6.0, 100.0, 0.0)
    light = stripe_light(STRAIGHT, width=1.5, height=110.0)
    light[:, 300:600] += step[:, 300:600]
    points = locate_stripe(exposed(light, rng))
    error = error_px(points, STRAIGHT)
    beside = (points.centre_px[:, 0] > 310.0) & (points.centre_px[:, 0] < 590.0)
    assert beside.sum() < 15
    assert len(points) > 900
    away = np.abs(points.centre_px[:, 0] - 450.0) > 170.0
    assert np.abs(error[away]).max() < 0.08


def test_smoothing_draws_a_bend_inwards_as_documented(rng):
    centre = 160.0 + 100.0 * np.sin(U / 150.0)
    picture = exposed(stripe_light(centre, width=3.0, height=200.0), rng, read=0.5)
    points = locate_stripe(picture)
    slope = np.gradient(centre)
    bend = np.interp(points.centre_px[:, 0], U, np.gradient(slope) / (1.0 + slope**2) ** 1.5)
    expected = 0.5 * 3.0**2 * bend
    strong = np.abs(expected) > 0.01
    error = error_px(points, centre)
    ratio = (error[strong] * expected[strong]).sum() / (expected[strong] ** 2).sum()
    assert ratio == pytest.approx(1.0, abs=0.25)
    assert np.abs(error - expected).max() < 0.03


@given(st.integers(-20, 20), st.integers(-30, 30))
@settings(max_examples=8, deadline=None)
def test_moving_the_picture_by_whole_pixels_moves_the_points_by_as_much(down, right):
    light = stripe_light(STRAIGHT[:400], shape=(200, 400))
    picture = exposed(light, np.random.default_rng(3))
    noise = PixelNoise(4.1)
    # Shrunk by two and four, pictures move alike only by multiples of eight.
    moved = np.roll(picture, (8 * (down // 8), 8 * (right // 8)), axis=(0, 1))
    one, other = (locate_stripe(p, noise=noise) for p in (picture, moved))
    keys = {tuple(np.rint(c).astype(int)): c for c in other.centre_px}
    shift = np.array([8 * (right // 8), 8 * (down // 8)])
    inner = one.centre_px[np.abs(one.centre_px[:, 0] - 200.0) < 100.0]
    apart = [
        keys[k] - shift - c for c in inner if (k := tuple(np.rint(c).astype(int) + shift)) in keys
    ]
    assert len(apart) > 150
    np.testing.assert_allclose(apart, 0.0, atol=1e-6)


def test_a_transposed_picture_gives_the_same_stripe(rng):
    picture = exposed(stripe_light(STRAIGHT[:400], shape=(200, 400)), rng)
    upright = locate_stripe(picture).centre_px
    lying = locate_stripe(np.ascontiguousarray(picture.T)).centre_px[:, ::-1]
    u = np.array([50.0, 200.0, 350.0])
    one, other = (np.polyval(np.polyfit(*points.T, 1), u) for points in (upright, lying))
    # Points lie in other pixels of the two, so they share noise but in part: 0.008 px / sqrt(60).
    np.testing.assert_allclose(one, other, atol=5e-3)


def test_normals_lie_across_the_stripe_and_are_of_unit_length(rng):
    points = locate_stripe(exposed(stripe_light(STRAIGHT), rng))
    np.testing.assert_allclose(np.linalg.norm(points.normal, axis=1), 1.0, atol=1e-9)
    along = np.array([1.0, 0.113]) / np.hypot(1.0, 0.113)
    assert np.abs(points.normal @ along).max() < 0.1


def test_only_the_region_is_looked_at(rng):
    picture = exposed(stripe_light(STRAIGHT), rng)
    region = np.zeros(SHAPE, dtype=bool)
    region[:, 400:700] = True
    u = locate_stripe(picture, region=region).centre_px[:, 0]
    assert (u.min(), u.max()) == (pytest.approx(400, abs=6), pytest.approx(700, abs=6))


def test_an_edge_is_no_stripe(rng):
    light = np.where(np.arange(SHAPE[0])[:, None] > STRAIGHT, 150.0, 20.0)
    assert len(locate_stripe(exposed(light, rng))) == 0


@pytest.mark.parametrize("shape", [(320, 1300), (700, 2048), (3, 4), (1, 1), (40, 2000)])
def test_a_dark_picture_gives_no_points_rather_than_an_error(rng, shape):
    assert len(locate_stripe(exposed(np.full(shape, 8.0), rng))) == 0


def test_a_picture_smaller_than_its_stripe_wants_is_survived(rng):
    centre = 15.0 + 0.0 * U[:60]
    light = stripe_light(centre, width=6.0, height=900.0, shape=(30, 60))
    assert len(locate_stripe(exposed(light, rng))) <= 60


def test_a_picture_of_nothing_but_texture_is_survived(rng):
    noise = rng.normal(size=(700, 2048))
    picture = np.clip(120.0 + 60.0 * noise, 0, 255).astype(np.uint8)
    assert len(locate_stripe(picture)) < 40_000


def test_input_is_not_changed(rng):
    picture = exposed(stripe_light(STRAIGHT), rng)
    picture.setflags(write=False)
    locate_stripe(picture)


def test_a_picture_of_another_kind_is_refused():
    with pytest.raises(ValueError, match="8 bit of shape"):
        locate_stripe(np.zeros((10, 10)))
    with pytest.raises(ValueError, match="region must have shape"):
        locate_stripe(np.zeros((10, 10), dtype=np.uint8), region=np.ones((9, 10), dtype=bool))
