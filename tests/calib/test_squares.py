"""A chessboard's black is taken off its picture, and nothing else is."""

import numpy as np

from calib.seeing.lattice import Lattice
from calib.seeing.squares import without_black

STEP, FIRST = 40.0, 80.0
NODES = np.stack(np.meshgrid(np.arange(5), np.arange(6), indexing="ij"), -1).reshape(-1, 2)
LATTICE = Lattice(NODES, np.arange(30), np.array([[0, STEP, FIRST], [STEP, 0, FIRST], [0, 0, 1.0]]))
PLACE = LATTICE.predict(NODES)


def board(height=320, width=360):
    v, u = np.mgrid[:height, :width]
    row, col = np.floor((v - FIRST) / STEP), np.floor((u - FIRST) / STEP)
    squares = (row >= -1) & (row < 5) & (col >= -1) & (col < 6)
    return np.where(squares & ((row + col) % 2 == 0), 20, 120).astype(np.uint8)


def on_squares(picture):
    """Return the middles of all squares but the four at the corners, which show one corner each."""
    middle = (FIRST + STEP * (np.arange(-1, 6) + 0.5)).astype(int)
    return picture[middle[1:5, None], middle[None, 1:6]]


def test_black_squares_become_as_bright_as_the_white_ones(rng):
    noisy = np.clip(board() + rng.normal(0.0, 2.0, (320, 360)), 0, 255).astype(np.uint8)
    # One pixel: 2 counts of noise, 1 by rounding down; five of them.
    assert np.abs(on_squares(without_black(noisy, LATTICE, PLACE)).astype(int) - 120).max() <= 11


def test_white_squares_and_what_is_off_the_board_stay_as_they_are():
    picture = board()
    lifted = without_black(picture, LATTICE, PLACE)
    off_board = np.s_[:30, :]
    np.testing.assert_array_equal(lifted[off_board], picture[off_board])
    assert on_squares(lifted)[on_squares(picture) == 120].tolist() == [120] * 10


def test_light_on_a_black_square_stays_on_it():
    picture = board()
    stripe = np.s_[95:98, 90:110]  # inside the square, clear of the edges' blur
    lit = picture.copy()
    lit[stripe] += 30
    more = without_black(lit, LATTICE, PLACE)[stripe].astype(int)
    less = without_black(picture, LATTICE, PLACE)[stripe].astype(int)
    np.testing.assert_allclose(more - less, 30, atol=1)


def test_the_picture_given_is_not_changed():
    picture = board()
    picture.setflags(write=False)
    without_black(picture, LATTICE, PLACE)
