"""The weights of points: nothing lost on clean data, nothing given to gross errors."""

import numpy as np
import pytest

from calib.solving.joint.mixture import Mixture, correlated_run


def settled(residual, rounds=30):
    mixture = Mixture.from_median(residual, np.full(len(residual), 0.1))
    for _ in range(rounds):
        mixture = mixture.updated(residual, mixture.weights(residual), spent=0.0)
    return mixture


@pytest.mark.parametrize("dimensions", [1, 2])
def test_clean_data_keep_practically_all_their_weight(rng, dimensions):
    residual = rng.normal(0.0, 1.7, (4000, dimensions))
    mixture = settled(residual)
    assert mixture.weights(residual).mean() > 0.998
    # 4,000 draws pin a standard deviation to 1.1 %; four of those.
    assert mixture.scale == pytest.approx(1.7, rel=0.045)


@pytest.mark.parametrize("dimensions", [1, 2])
def test_a_fifth_of_gross_errors_is_found_and_does_not_widen_the_scale(rng, dimensions):
    residual = rng.normal(0.0, 1.0, (2000, dimensions))
    residual[:400] += rng.choice([-1.0, 1.0], (400, dimensions)) * rng.uniform(
        15.0, 500.0, (400, dimensions)
    )
    mixture = settled(residual)
    assert not mixture.believed(residual)[:400].any()
    assert mixture.believed(residual)[400:].mean() > 0.998
    assert mixture.scale == pytest.approx(1.0, rel=0.08)
    # The box reaches under the normal: points beyond 3.3 sigma are shared.
    assert mixture.share == pytest.approx(0.2, abs=0.02)


def test_far_from_the_answer_no_point_is_locked_out(rng):
    residual = rng.normal(0.0, 100.0, (500, 1))
    mixture = Mixture.from_median(residual, np.full(500, 0.1))
    assert mixture.weights(residual).min() > 0.2


def test_noise_free_points_are_not_believed_more_than_a_thousandth_of_a_pixel():
    mixture = settled(np.zeros((50, 2)))
    assert mixture.scale * 0.1 == pytest.approx(1e-3)


def test_independent_points_count_for_themselves(rng):
    runs = [
        correlated_run(
            rng.normal(size=600), np.ones(600), np.repeat([0, 1, 2], 200), np.arange(600)
        )
        for _ in range(20)
    ]
    # A first lag beyond two standard deviations comes by chance in one of forty.
    assert np.median(runs) == 1.0


def test_smoothed_points_count_for_as_many_as_they_are(rng):
    # A kernel of standard deviation 2 gives correlations exp(-k^2 / 16), summing to 7.09.
    kernel = np.exp(-0.125 * np.arange(-10, 11) ** 2)
    noise = np.array([np.convolve(rng.normal(size=320), kernel, "valid") for _ in range(20)])
    group = np.repeat(np.arange(20), 300)
    along = np.tile(np.arange(300), 20)
    shuffled = rng.permutation(6000)
    order = shuffled[np.argsort(group[shuffled], kind="stable")]
    run = correlated_run(noise.ravel()[order], np.ones(6000), group[order], along[order])
    # 6,000 points of runs of 7 leave 850 independent ones, 5 % on the sum of correlations.
    assert run == pytest.approx(7.09, rel=0.2)
