"""Which point is which: never a wrong answer, and an answer wherever it is certain."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from calib.homography import apply_homography
from calib.seeing.lattice import Lattice, find_lattice
from calib.seeing.numbering import inside_target, number

ROWS, COLS = 7, 8


def seen(turn, tilt, stretch=0.0):
    """Return a homography from (row, col) to the picture."""
    cos, sin = np.cos(turn), np.sin(turn)
    step = 50.0 * np.array([[-sin, cos], [cos, sin]])  # columns: one row down, one column right
    homography = np.eye(3)
    homography[:2, :2] = step
    homography[:2, 2] = [600.0, 400.0]
    homography[2, :2] = tilt
    bend = np.eye(3)
    bend[0, 0] += stretch
    return bend @ homography


def grid(rows=ROWS, cols=COLS):
    return np.stack(np.meshgrid(np.arange(rows), np.arange(cols), indexing="ij"), -1).reshape(-1, 2)


def numbered(points, size, rows=ROWS, cols=COLS):
    """Return {index of a point: (row, col)}, or None."""
    lattice = find_lattice(points, size, rows, cols)
    if lattice is None:
        return None
    numbering = number(lattice.node, lattice.picture_from_node, rows, cols)
    if numbering is None:
        return None
    place = numbering.rows_and_cols(lattice.node)
    mine = inside_target(place, rows, cols)
    return dict(zip(lattice.index[mine].tolist(), map(tuple, place[mine].tolist()), strict=True))


@example(turn=0.0, tilt=(-0.03, -0.03), seed=9, lost=8, false=22)
@given(
    turn=st.floats(-0.7, 0.7),
    tilt=st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)),
    seed=st.integers(0, 10_000),
    lost=st.integers(0, 16),
    false=st.integers(0, 40),
)
@settings(max_examples=40, deadline=None)
def test_a_numbering_is_right_or_refused(turn, tilt, seed, lost, false):
    rng = np.random.default_rng(seed)
    truth = grid()
    points = apply_homography(seen(turn, np.array(tilt)), truth.astype(float))
    keep = np.sort(rng.permutation(len(truth))[lost:])
    others = rng.uniform([300, 200], [1300, 1000], (false, 2))
    everything = np.concatenate([points[keep] + rng.normal(scale=0.4, size=(len(keep), 2)), others])
    found = numbered(everything, rng.uniform(13.0, 15.0, len(everything)))
    if found is None:
        # With few lost, and few others, it must be found.
        assert lost > 8 or false > 10
        return
    off = [i for i, place in found.items() if i < len(keep) and place != tuple(truth[keep[i]])]
    assert not off


@given(st.sampled_from(["row", "col"]), st.booleans(), st.floats(-0.6, 0.6))
@settings(max_examples=20, deadline=None)
def test_a_border_that_is_not_seen_leaves_it_uncertain(line, last, turn):
    truth = grid()
    axis = 0 if line == "row" else 1
    edge = ((ROWS, COLS)[axis] - 1) if last else 0
    truth = truth[truth[:, axis] != edge]
    points = apply_homography(seen(turn, np.zeros(2)), truth.astype(float))
    assert numbered(points, np.full(len(points), 14.0)) is None


@pytest.mark.parametrize("turn", np.deg2rad([-40, -20, 0, 20, 40]))
@pytest.mark.parametrize(("rows", "cols"), [(7, 8), (7, 7), (4, 9), (2, 3)])
def test_rows_run_down_and_columns_right_up_to_45_degrees(turn, rows, cols):
    truth = grid(rows, cols)
    points = apply_homography(seen(turn, np.array([0.004, -0.003])), truth.astype(float))
    found = numbered(points, np.full(len(points), 14.0), rows, cols)
    assert found is not None
    assert [found[i] for i in range(len(truth))] == list(map(tuple, truth.tolist()))


@pytest.mark.parametrize("turn", np.deg2rad([70, 90, 110, 160, -100]))
def test_an_oblong_target_may_lie_on_its_side(turn):
    truth = grid()
    points = apply_homography(seen(turn, np.zeros(2)), truth.astype(float))
    found = numbered(points, np.full(len(points), 14.0))
    assert found is not None
    place = np.array([found[i] for i in range(len(truth))])
    same, turned = (place == truth).all(), (place == [ROWS - 1, COLS - 1] - truth).all()
    assert same or turned
    down = points[place.tolist().index([1, 0])] - points[place.tolist().index([0, 0])]
    assert down[1] > -1e-6


def test_a_strong_slant_does_not_confuse_steps_and_diagonals():
    truth = grid()
    homography = seen(0.7, np.zeros(2), stretch=-0.45)
    points = apply_homography(homography, truth.astype(float))
    found = numbered(points, np.full(len(points), 14.0))
    assert found is not None
    assert [found[i] for i in range(len(truth))] == list(map(tuple, truth.tolist()))


def test_points_at_random_are_no_target(rng):
    for _ in range(5):
        points = rng.uniform(0.0, 1000.0, (150, 2))
        assert numbered(points, np.full(150, 14.0)) is None


@given(st.integers(0, 5))
@settings(deadline=None)
def test_too_few_points_are_no_lattice(count):
    assume(count < 6)
    assert (
        find_lattice(np.random.default_rng(0).uniform(size=(count, 2)), np.ones(count), 7, 8)
        is None
    )


@pytest.mark.parametrize("rows_of_wall", [9, 12])
def test_a_larger_lattice_behind_the_target_is_not_taken_for_it(rows_of_wall):
    mine = apply_homography(seen(0.3, (0.01, -0.01)), grid().astype(float))
    wall = 41.0 * grid(rows_of_wall, 30)
    covered = np.linalg.norm(wall[:, None] - mine[None], axis=2).min(axis=1) < 40.0
    points = np.concatenate([wall[~covered], mine])
    found = numbered(points, np.ones(len(points)))
    assert found is not None
    first = int((~covered).sum())
    assert {found[first + i] for i in range(ROWS * COLS)} == set(map(tuple, grid().tolist()))


def test_a_lattice_of_more_points_than_the_target_counts_those_against_it():
    lattice = Lattice(grid(10, 10), np.arange(100), np.eye(3))
    # A window of 7 x 8 holds 56 of the hundred; 44 lie outside.
    assert lattice.likeness(7, 8) == 56 - 44
