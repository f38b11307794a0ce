"""Is the noise of a picture that of the chip?  Says nothing of where the light comes from."""

import numpy as np
import pytest

from station.scenes import Detector

DETECTOR = Detector()


def even_light(counts, size=512):
    return np.full((size, size), counts, dtype=np.float32)


@pytest.mark.parametrize("counts", [20.0, 60.0, 200.0])
def test_variance_grows_with_the_signal_as_the_gain_says(rng, counts):
    picture = DETECTOR.expose(even_light(counts), rng).astype(float)
    # 262144 pixels pin a variance to 0.28 %; five of those is 1.4 %.
    assert picture.var() == pytest.approx(DETECTOR.variance_counts2(counts), rel=0.014)


def test_slope_of_variance_over_signal_is_one_over_the_electrons_per_count(rng):
    levels = np.array([20.0, 80.0, 140.0, 200.0])
    variances = [DETECTOR.expose(even_light(level), rng).astype(float).var() for level in levels]
    slope = np.polyfit(levels, variances, 1)[0]
    # Each variance is pinned to 0.28 % of up to 3.9; over a span of 180 counts the slope, 0.0189,
    # is pinned to about 0.4 %.
    assert slope == pytest.approx(1.0 / DETECTOR.electrons_per_count, rel=0.02)


def test_mean_is_offset_plus_light(rng):
    # Standard error 0.004 counts.
    assert DETECTOR.expose(even_light(100.0), rng).mean() == pytest.approx(103.0, abs=0.02)


def test_exposure_scales_the_light_and_not_the_offset(rng):
    assert DETECTOR.expose(even_light(50.0), rng, 2.0).mean() == pytest.approx(103.0, abs=0.02)
    assert DETECTOR.expose(even_light(50.0), rng, 0.0).mean() == pytest.approx(3.0, abs=0.02)


def test_light_beyond_the_full_well_gives_white_everywhere(rng):
    assert (DETECTOR.expose(even_light(400.0), rng) == 255).mean() > 0.7
    # The full well holds 254.7 counts: with the offset of 3, 1.4 standard deviations over white.
    assert DETECTOR.expose(even_light(4000.0), rng).min() > 240


def test_the_same_generator_gives_the_same_picture():
    light = even_light(30.0, size=64)
    pictures = [DETECTOR.expose(light, np.random.default_rng(5)) for _ in range(2)]
    np.testing.assert_array_equal(*pictures)


def test_the_light_is_left_as_it_was(rng):
    light = even_light(300.0, size=16)
    light.setflags(write=False)
    DETECTOR.expose(light, rng, 1.0)


@pytest.mark.parametrize("exposure", [-1.0, np.nan, np.inf])
def test_impossible_exposure_is_refused(rng, exposure):
    with pytest.raises(ValueError, match="exposure"):
        DETECTOR.expose(even_light(1.0, size=4), rng, exposure)


@pytest.mark.parametrize(
    "wrong",
    [{"electrons_per_count": 0.0}, {"full_well_e": np.nan}, {"read_noise_e": -1.0}],
)
def test_impossible_chip_is_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Detector(**wrong)
