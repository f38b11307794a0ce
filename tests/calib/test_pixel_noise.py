"""The noise of pixels told from pictures that show things as well.

They say nothing of noise that neighbours share, as a picture scaled up has it.
"""

import numpy as np
import pytest

from calib import PixelNoise


def stripes_and_spots(shape=(600, 1200)):
    v, u = np.mgrid[: shape[0], : shape[1]].astype(float)
    light = 12.0 + 60.0 * u / shape[1]
    light += 140.0 * np.exp(-0.5 * ((v - 200.0 - 0.1 * u) / 2.5) ** 2)
    return light + 90.0 * (np.hypot((u % 90.0) - 45.0, (v % 90.0) - 45.0) < 14.0)


@pytest.mark.parametrize(("read", "gain"), [(1.0, 0.0), (3.0, 0.0), (1.0, 0.06), (2.0, 0.15)])
def test_noise_is_found_among_stripes_and_spots(rng, read, gain):
    light = stripes_and_spots()
    noisy = light + rng.normal(size=light.shape) * np.sqrt(read**2 + gain * light)
    noise = PixelNoise.from_picture(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    brightness = np.array([20.0, 60.0, 120.0])
    true = read**2 + gain * brightness + 1.0 / 12.0
    # The median of 2,000 correlated masks in the scarcest class errs by 4 % of sigma; edges of
    # spots add some: 10 % of sigma is 20 % of the variance.
    np.testing.assert_allclose(noise.variance(brightness), true, rtol=0.2)


def test_a_flat_picture_without_noise_has_that_of_its_bits():
    assert PixelNoise.from_picture(np.full((200, 300), 40, dtype=np.uint8)).floor == 1.0 / 12.0


@pytest.mark.parametrize("value", [0, 255])
def test_a_black_or_clipped_picture_says_nothing_of_noise(value):
    noise = PixelNoise.from_picture(np.full((200, 300), value, dtype=np.uint8))
    assert (noise.floor, noise.gain) == (1.0 / 12.0, 0.0)


@pytest.mark.parametrize("shape", [(0, 0), (1, 500), (2, 2), (3, 3)])
def test_a_picture_too_small_to_tell_is_no_error(shape):
    assert PixelNoise.from_picture(np.zeros(shape, dtype=np.uint8)).floor > 0.0


@pytest.mark.parametrize(("floor", "gain"), [(0.0, 0.0), (np.nan, 0.0), (1.0, -0.1), (1.0, np.nan)])
def test_noise_that_cannot_be_is_refused(floor, gain):
    with pytest.raises(ValueError, match="noise floor"):
        PixelNoise(floor, gain)


@pytest.mark.parametrize("slope", [-0.2, 0.05, 0.3])
def test_a_stripe_alone_in_the_dark_tells_what_brightness_adds(rng, slope):
    v, u = np.mgrid[:1088, :2048].astype(float)
    light = 18.0 + 150.0 * np.exp(-0.5 * ((v - 500.0 - slope * (u - 1000.0)) / 2.0) ** 2)
    noisy = light + rng.normal(size=light.shape) * np.sqrt(1.0 + 0.05 * light)
    noise = PixelNoise.from_picture(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    # Of about 1,500 bright pixels the mask's bend of the stripe itself spares few: over 12 such
    # pictures the deviation at the flank scattered by 2.3 %, 5 % of the variance; four of them.
    np.testing.assert_allclose(noise.variance(np.array([70.0])), 1.0 + 3.5 + 1.0 / 12.0, rtol=0.2)


def test_the_flanks_of_a_thin_stripe_are_not_taken_for_noise(rng):
    v, u = np.mgrid[:1088, :2048].astype(float)
    light = 10.0 + 180.0 * np.exp(-0.5 * ((v - 500.0 - 0.2 * u) / 1.2) ** 2)
    noisy = light + 0.5 * rng.normal(size=light.shape)
    noise = PixelNoise.from_picture(np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    # At a flank the mask leaves 80 counts of the stripe.
    assert noise.variance(np.array([120.0]))[0] < 2.0 * (0.25 + 1.0 / 12.0)
