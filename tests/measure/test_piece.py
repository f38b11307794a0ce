"""What a reference piece is, and what is refused as one."""

import numpy as np
import pytest
from piece_stripes import comb

from measure import Piece, PieceFace, PieceInvalid


def test_points_placed_on_a_side_come_back_at_their_place():
    for face in (
        PieceFace(np.array([1.0, 2.0]), np.array([6.0, -3.0])),
        PieceFace.through(np.array([0.0, 0.0]), np.array([5.0, 5.0]), np.array([10.0, 0.0])),
        PieceFace.through(np.array([0.0, 0.0]), np.array([5.0, -5.0]), np.array([10.0, 0.0])),
    ):
        along = np.linspace(0.0, face.length_mm, 9)
        points, normals = face.points(along)
        np.testing.assert_allclose(points[[0, -1]], [face.start_mm, face.end_mm], atol=1e-12)
        there, outside = face.place(points + 0.25 * normals)
        np.testing.assert_allclose(outside, 0.25, atol=1e-12)
        np.testing.assert_allclose(there, along, atol=1e-12)


def test_a_round_side_bulges_where_its_middle_lies_above_the_chord():
    ends = np.array([0.0, 0.0]), np.array([10.0, 0.0])
    hill = PieceFace.through(ends[0], np.array([5.0, 5.0]), ends[1])
    hollow = PieceFace.through(ends[0], np.array([5.0, -5.0]), ends[1])
    assert (hill.side, hollow.side) == (1.0, -1.0)
    for face in (hill, hollow):
        # Metal lies below: out of it is up.
        assert face.points(np.array([0.5 * face.length_mm]))[1][0, 1] == pytest.approx(1.0)
        assert face.radius_mm == pytest.approx(5.0)


def test_a_step_has_its_height_between_two_levels():
    step = Piece.step(10.0, width_mm=25.0)
    assert [face.length_mm for face in step.faces] == [25.0, 10.0, 25.0]
    assert step.faces[2].start_mm[1] - step.faces[0].start_mm[1] == 10.0


def test_a_piece_of_steel_is_longer_when_warm():
    warm = comb(expansion_per_k=11.5e-6).warmed(40.0)
    assert warm.size_mm == pytest.approx(comb().size_mm * (1.0 + 20.0 * 11.5e-6))


def test_unknown_warmth_and_slant_leave_the_size_in_doubt():
    piece = comb(expansion_per_k=11.5e-6, squareness_deg=0.0)
    assert piece.stretch_u95(15.0) == 0.0
    assert piece.stretch_u95(None) == pytest.approx(20.0 * 11.5e-6)
    # 1 / cos(2 degrees) = 1.00061.
    assert comb(squareness_deg=2.0).stretch_u95(15.0) == pytest.approx(6.1e-4, rel=1e-2)


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([[(0, 0)]], "two or more"),
        ([[(0, 0)], [(0, 0)]], "corners that differ"),
        ([[(0, 0)], [(1, np.nan)]], "x and z in mm"),
        ([[(0, 0)], [(1, 1), (2, 2)]], "no arc"),
        ([[(0, 0), (1, 1)], [(2, 2)]], "first corner"),
    ],
)
def test_corners_that_make_no_profile_are_refused(corners, words):
    with pytest.raises(PieceInvalid, match=words):
        Piece.from_corners("bad", "", corners)


@pytest.mark.parametrize("height", [0.0, -1.0, np.nan, 1e4])
def test_a_step_of_no_height_is_refused(height):
    with pytest.raises(PieceInvalid, match="height"):
        Piece.step(height)


@pytest.mark.parametrize(
    "about",
    [
        {"u95_mm": -1.0},
        {"squareness_deg": np.nan},
        {"held_u95_mm": -0.1},
        {"length_in_rig": (0.0, 0.0, 0.0)},
    ],
)
def test_figures_out_of_range_are_refused(about):
    with pytest.raises(PieceInvalid, match="allowed"):
        comb(**about)
