"""A profile is one curve: of several that cross or run side by side, one is taken whole."""

import numpy as np
import pytest

from measure.keeping.layers import one_layer


def both(first, second, step_mm=0.3):
    """Two curves over the same 100 mm, as (along, outside, which)."""
    along = np.arange(0.0, 100.0, step_mm)
    return (
        np.concatenate([along, along]),
        np.concatenate([first(along), second(along)]),
        np.repeat([0, 1], len(along)),
    )


@pytest.mark.parametrize("unworn_until_mm", [30.0, 10.0])
def test_the_curve_that_fits_where_nothing_wears_is_taken_to_its_end(unworn_until_mm):
    along, outside, which = both(lambda s: -0.03 * s, lambda s: 0.8 - 0.1 * s)
    keep = one_layer(along, outside, along < unworn_until_mm)
    # The two cross at s = 11; within 0.8 mm of one another, to s = 23, they are one cluster.
    assert keep[which == 0].all()
    assert keep[(which == 1) & (along > 24.0)].sum() == 0


def test_a_gap_is_crossed_on_the_same_curve():
    along, outside, which = both(lambda s: 0.0 * s, lambda s: -5.0 + 0.0 * s)
    seen = ~((along > 40.0) & (along < 60.0) & (which == 0))
    keep = one_layer(along[seen], outside[seen], along[seen] < 35.0)
    kept = np.flatnonzero(seen)[keep]
    assert (which[kept][along[kept] > 61.0] == 0).all()


def test_a_single_curve_is_kept_whole_however_steep():
    along = np.arange(0.0, 50.0, 0.3)
    assert one_layer(along, 1.5 * np.abs(along - 25.0), along < 10.0).all()


def test_order_does_not_matter(rng):
    along, outside, which = both(lambda s: 0.01 * s, lambda s: -3.0 + 0.0 * s)
    unworn = along < 20.0
    shuffled = rng.permutation(len(along))
    keep = one_layer(along, outside, unworn)
    np.testing.assert_array_equal(
        one_layer(along[shuffled], outside[shuffled], unworn[shuffled]), keep[shuffled]
    )
    assert (keep == (which == 0)).all()


def test_nothing_stays_nothing():
    assert len(one_layer(np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))) == 0
