"""The analytic references read what EN 13715 and the LMA drawing say they read."""

import numpy as np
import pytest

from measure import (
    Quantity,
    ReferenceInvalid,
    ReferenceProfile,
    ReferenceUnknown,
    reference_profile,
)

BOTH = ("S1002", "LMA")


@pytest.mark.parametrize(
    ("name", "height", "at_10", "at_12", "gradient"),
    [("S1002", 28.0, 32.5, 31.573, 10.794), ("LMA", 28.0, 32.9, 31.974, 9.739)],
)
def test_nominal_readings_are_those_of_the_drawing(name, height, at_10, at_12, gradient):
    nominal = reference_profile(name).nominal
    # The drawing's figures are given to 1e-3; LMA's coordinates, to 1e-6, carry their rounding.
    assert nominal[Quantity.FLANGE_HEIGHT] == pytest.approx(height, abs=1e-5)
    assert nominal[Quantity.FLANGE_THICKNESS_10] == pytest.approx(at_10, abs=6e-4)
    assert nominal[Quantity.FLANGE_THICKNESS_12] == pytest.approx(at_12, abs=6e-4)
    assert nominal[Quantity.FLANGE_GRADIENT_QR] == pytest.approx(gradient, abs=1e-3)


@pytest.mark.parametrize("name", BOTH)
def test_pieces_meet_within_the_rounding_of_their_coefficients(name):
    pieces = reference_profile(name).segments
    for before, after in zip(pieces, pieces[1:], strict=False):
        joint = np.array([before.end_mm])
        assert before.height_mm(joint) == pytest.approx(after.height_mm(joint), abs=1.2e-4)


@pytest.mark.parametrize("name", BOTH)
def test_height_is_zero_on_the_tape_circle_and_nan_outside(name):
    reference = reference_profile(name)
    assert reference.height_mm(0.0) == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(reference.height_mm([-70.01, reference.end_mm + 0.01])).all()


@pytest.mark.parametrize("name", BOTH)
def test_points_are_even_along_the_profile_and_start_down_the_back_face(name):
    points = reference_profile(name).points(0.5, back_face_mm=10.0)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    # A chord is shorter than its arc by s^3 / 24 R^2, 0.04 % on R = 12, and by 4 % over a corner
    # of 45 degrees as LMA's chamfer has.
    np.testing.assert_allclose(steps, 0.5, rtol=0.04)
    assert (points[:20, 0] == -70.0).all()
    assert points[0, 1] == pytest.approx(points[20, 1] - 10.0)


def test_reference_of_dense_points_reads_like_the_analytic_one():
    analytic = reference_profile("S1002")
    y, z = analytic.points(0.1).T
    table = ReferenceProfile.from_points("table", y[::-1], z[::-1] + 3.0)
    for quantity, value in analytic.nominal.items():
        # Chords of 0.1 mm on R = 12 lie 0.1 um below the arc; a steep face turns that to 1 um.
        assert table.nominal[quantity] == pytest.approx(value, abs=1e-3)


def test_points_that_scatter_about_the_flange_back_make_no_steps(rng):
    analytic = reference_profile("S1002")
    y, z = analytic.points(0.2, back_face_mm=25.0).T
    scattered = y + np.where(y <= -70.0, rng.normal(0.0, 0.1, len(y)), 0.0)
    order = rng.permutation(len(y))
    table = ReferenceProfile.from_points("table", scattered[order], z[order])
    inner = np.linspace(-69.0, 55.0, 500)
    # Chords of 0.2 mm where the flange is steep, 1 in 5 of a mm beside the back.
    np.testing.assert_allclose(table.height_mm(inner), analytic.height_mm(inner), atol=5e-3)
    assert table.start_mm >= -70.0
    assert table.height_mm(table.start_mm) > 5.0


def test_unknown_name_is_refused_with_the_known_ones():
    with pytest.raises(ReferenceUnknown, match="S1002, LMA"):
        reference_profile("S1003")


@pytest.mark.parametrize(
    ("y", "z", "match"),
    [
        (np.linspace(-20, 60, 200), np.zeros(200), "a reference needs"),
        (np.linspace(-69, 60, 200), np.zeros(200), "flange"),
        (np.linspace(-69, 60, 200), np.full(200, np.nan), "finite"),
        ([], [], "no points"),
    ],
)
def test_points_that_are_no_wheel_make_no_reference(y, z, match):
    with pytest.raises(ReferenceInvalid, match=match):
        ReferenceProfile.from_points("bad", y, z)
