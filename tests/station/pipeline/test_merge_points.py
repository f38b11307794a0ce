"""Merged points are nearer the truth than any picture's, and their sigma says by how much.

Drawn points; that rendered pictures share as much of their errors as is found is measured by
`station bench pairs`.
"""

import numpy as np
import pytest

from calib import Cause, TargetPoints
from station.pipeline.merge_points import merge_points

GOOD, BAD = Cause.NONE, Cause.SATURATED
COUNT = 400


def drawn(rng, sigmas, *, common):
    """Pictures of points at (0, 0) with these sigmas, `common` px of each the same in all."""
    together = rng.normal(0.0, common, (COUNT, 2)) if common else np.zeros((COUNT, 2))
    return [
        TargetPoints(
            row=np.arange(COUNT) // 20,
            col=np.arange(COUNT) % 20,
            centre_px=together + rng.normal(0.0, np.sqrt(sigma**2 - common**2), (COUNT, 2)),
            sigma_px=np.full((COUNT, 2), sigma),
            cause=(GOOD,) * COUNT,
        )
        for sigma in sigmas
    ]


def few(causes, sigmas, places=None):
    count = len(causes)
    return TargetPoints(
        row=np.zeros(count),
        col=np.arange(count) if places is None else places,
        centre_px=np.array([[sigma, -sigma] for sigma in sigmas]),
        sigma_px=np.array([[sigma, sigma] for sigma in sigmas]),
        cause=tuple(causes),
    )


@pytest.mark.parametrize("common", [0.0, 0.005, 0.008, 0.0099])
@pytest.mark.parametrize("sigmas", [(0.01, 0.01), (0.01, 0.02), (0.01, 0.01, 0.02, 0.02)])
def test_sigma_of_merged_points_is_their_scatter(rng, sigmas, common):
    merged = merge_points(drawn(rng, sigmas, common=common))
    # 800 numbers tell a deviation to 2.5 %, and the common share, by medians of as many, to some
    # 0.08: 4 % of sigma where it matters the most.
    assert np.std(merged.centre_px / merged.sigma_px) == pytest.approx(1.0, abs=0.12)


@pytest.mark.parametrize("common", [0.0, 0.005, 0.008])
def test_merged_points_are_as_near_as_the_best_linear_mean(rng, common):
    sigmas = np.array([0.01, 0.015, 0.02])
    merged = merge_points(drawn(rng, sigmas, common=common))
    best = np.sqrt(common**2 + 1.0 / np.sum(1.0 / (sigmas**2 - common**2)))
    assert np.sqrt(np.mean(merged.centre_px**2)) == pytest.approx(best, rel=0.08)


def test_pictures_that_err_alike_give_the_best_one_of_them(rng):
    better, worse = drawn(rng, (0.01, 0.02), common=0.00999)
    merged = merge_points([worse, better])
    # The share told to 0.05 gives the worse picture 2 % of the weight: of some 0.05 px at most.
    np.testing.assert_allclose(merged.centre_px, better.centre_px, atol=2e-3)
    # Never told to be better than what both pictures share.
    np.testing.assert_allclose(merged.sigma_px, 0.01, rtol=0.03)


def test_few_points_in_common_are_taken_from_where_they_are_sharpest():
    merged = merge_points([few([GOOD] * 3, [0.3, 0.1, 0.1]), few([GOOD] * 3, [0.2, 0.2, 0.3])])
    np.testing.assert_allclose(merged.sigma_px[:, 0], [0.2, 0.1, 0.1], rtol=1e-5)
    np.testing.assert_allclose(merged.centre_px[:, 0], [0.2, 0.1, 0.1], rtol=1e-4)


def test_doubtful_point_serves_only_where_no_picture_shows_it_well():
    one = few([GOOD, GOOD, BAD], [0.3, 0.1, 0.1])
    other = few([GOOD, BAD, BAD], [0.2, 0.05, 0.3])
    merged = merge_points([one, other])
    np.testing.assert_allclose(merged.sigma_px[:, 0], [0.2, 0.1, 0.1], rtol=1e-5)
    assert merged.cause == (GOOD, GOOD, BAD)


def test_every_point_that_any_picture_shows_is_there_row_by_row():
    merged = merge_points([few([GOOD] * 2, [0.1, 0.2], [3, 0]), few([BAD], [0.1], [1])])
    assert merged.col.tolist() == [0, 1, 3]
    assert merged.cause == (GOOD, BAD, GOOD)
    np.testing.assert_allclose(merged.sigma_px[:, 0], [0.2, 0.1, 0.1])


def test_one_picture_stays_as_it_is(rng):
    (alone,) = drawn(rng, (0.01,), common=0.0)
    merged = merge_points([alone])
    np.testing.assert_allclose(merged.centre_px, alone.centre_px)
    np.testing.assert_allclose(merged.sigma_px, alone.sigma_px)


def test_no_picture_is_refused():
    with pytest.raises(ValueError, match="at least one"):
        merge_points([])
