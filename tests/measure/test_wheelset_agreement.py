"""Of several looks at one thing the one that contradicts the others is named, and none where more
than one may be it.  The looks are numbers with a mean; circles and axles have their own tests."""

import numpy as np
import pytest

from measure.wheelset.agreement import Residuals, agreeing


def mean_of(values, covariance, look=None):
    """The residuals of a generalised mean."""

    def residuals_of(some):
        chosen = np.flatnonzero(np.isin(looks, some))
        noise = covariance[np.ix_(chosen, chosen)]
        weight = np.linalg.solve(noise, np.ones(len(chosen)))
        off = values[chosen] - weight @ values[chosen] / weight.sum()
        names = np.searchsorted(some, looks[chosen])
        return Residuals(off, noise, np.full(noise.shape, 1.0 / weight.sum()), names)

    looks = np.arange(len(values)) if look is None else np.array(look)
    return residuals_of


def told(values, *, fewest=2, sigma=0.1):
    values = np.array(values)
    covariance = np.eye(len(values)) * sigma**2
    kept = agreeing(len(values), mean_of(values, covariance), fewest=fewest)
    return None if kept is None else kept.tolist()


def sum_of_squares(residuals):
    return residuals.residual_mm @ np.linalg.solve(residuals.covariance, residuals.residual_mm)


def test_the_sum_of_squares_falls_by_what_a_fit_without_the_look_says(rng):
    mixed = rng.normal(size=(8, 8))
    look = [0, 0, 1, 2, 2, 2, 3, 3]
    values, covariance = rng.normal(size=8), mixed @ mixed.T + np.eye(8)
    residuals_of = mean_of(values, covariance, look)
    whole = residuals_of(np.arange(4))
    falls, freedoms = whole.suspicions()
    for out in range(4):
        rest = residuals_of(np.delete(np.arange(4), out))
        assert falls[out] == pytest.approx(sum_of_squares(whole) - sum_of_squares(rest), rel=1e-9)
    assert freedoms.tolist() == [2, 1, 3, 2]


def test_looks_that_agree_are_all_kept():
    assert told([1.0, 1.1, 0.9, 1.05]) == [0, 1, 2, 3]


def test_those_that_contradict_are_left_out_one_by_one():
    assert told([1.0, 1.1, 3.0, 0.9, 1.05]) == [0, 1, 3, 4]
    assert told([1.0, 1.1, 3.0, 0.9, 1.05, 1.0, -2.0]) == [0, 1, 3, 4, 5]


def test_where_two_may_be_the_wrong_one_none_is_named():
    assert told([1.0, 3.0]) is None
    assert told([1.0, 1.05, 3.0, 3.05]) is None
    # The middle one agrees with either of the others.
    assert told([1.0, 1.3, 1.6]) is None


def test_so_many_must_be_left():
    assert told([1.0, 1.1, 3.0], fewest=2) == [0, 1]
    assert told([1.0, 1.1, 3.0], fewest=3) is None


def test_more_than_half_must_be_left():
    # Three wild ones go one by one; with a fourth of seven the rest would be a minority.
    assert told([1.0, 1.0, 1.05, 0.95, 9.0, -7.0, 5.0]) == [0, 1, 2, 3]
    assert told([1.0, 1.0, 1.05, 9.0, -7.0, 5.0, 14.0]) is None


def test_a_fit_that_fails_names_none():
    assert agreeing(3, lambda _: None, fewest=2) is None
