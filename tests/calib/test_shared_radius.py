"""Is the radius that several sections share found, and is its interval true?"""

import numpy as np
import pytest

from calib.judging.section import form_of_slope, radius_of_form
from calib.judging.shared_radius import KnownForm, SharedRadius

RADIUS_MM = 30.0
# As an arc of 130 degrees knows the form: mean and lean are nearly told apart by nothing.
KNOWN = np.array([0.35, 0.06, 0.05])


def forms(rng, *, count=9, tilt_deg=8.0):
    slopes = np.tan(np.radians(tilt_deg)) * rng.normal(size=(count, 2))
    answer = []
    for slope in slopes:
        # The least known direction is mean against lean, anywhere along the arc's own middle.
        chi = rng.uniform(0.0, 2.0 * np.pi)
        weak = np.array([1.0, np.cos(chi), np.sin(chi)]) / np.sqrt(2.0)
        basis = np.linalg.qr(np.column_stack([weak, np.eye(3)[:, :2]]))[0]
        covariance = (basis * (KNOWN / 3.0) ** 2) @ basis.T
        exact = RADIUS_MM * form_of_slope(slope)
        answer.append(KnownForm(rng.multivariate_normal(exact, covariance), covariance))
    return answer


@pytest.mark.parametrize("tilt_deg", [1.0, 8.0])
def test_interval_of_the_radius_holds_the_truth_as_often_as_it_says(rng, tilt_deg):
    answers = [SharedRadius.of(forms(rng, tilt_deg=tilt_deg)) for _ in range(15)]
    off = np.array([answer.radius_mm - RADIUS_MM for answer in answers])
    half = np.array([answer.half_mm for answer in answers])
    # 95 % of 15 is 14; three standard deviations of that count are 2.5.
    assert (np.abs(off) < half).sum() >= 12
    # The interval is not wider than it need be: 15 draws pin a scatter to 18 %. Where no axis
    # leans, the prior's least tilt of half a degree costs nearly nothing.
    assert np.sqrt(np.mean((off / half) ** 2)) * 1.96 == pytest.approx(1.0, abs=0.45)


def test_minor_semi_axes_alone_would_be_too_small(rng):
    round_ones = forms(rng, count=60, tilt_deg=1.0)
    minor = np.array([radius_of_form(form.form_mm) for form in round_ones])
    shared = SharedRadius.of(round_ones)
    assert minor.mean() - RADIUS_MM < -0.03
    assert abs(shared.radius_mm - RADIUS_MM) < 1.5 * shared.half_mm
    assert shared.half_mm < 0.03


def test_tilt_of_the_axes_is_told(rng):
    answer = SharedRadius.of(forms(rng, count=30, tilt_deg=8.0))
    # Sixty slopes pin their spread to 9 %; the steps of the tilts are 67 %.
    assert np.degrees(answer.tilt_rad) == pytest.approx(8.0, rel=0.7)


def test_shift_of_all_forms_alike_shifts_the_radius_as_much(rng):
    known = forms(rng)
    answer = SharedRadius.of(known)
    shift = np.array([0.01, 0.0, 0.0])
    assert answer.by_shift(known, [shift] * len(known)) == pytest.approx(0.01, rel=0.05)


def test_likelihood_is_the_integral_over_the_axis(rng):
    (form,) = forms(rng, count=1)
    radii, tilt = np.array([29.9, 30.0, 30.1]), np.radians(6.0)
    # By hand: the slope on a fine grid, each with its form's normal law and its own prior.
    edge = np.linspace(-0.8, 0.8, 801)
    p, q = np.meshgrid(edge, edge)
    square = p**2 + q**2
    half = 0.5 * (np.sqrt(1.0 + square) - 1.0)
    angle = 2.0 * np.arctan2(q, p)
    shape = np.stack([1.0 + half, half * np.cos(angle), half * np.sin(angle)], axis=-1)
    by_hand = []
    for radius in radii:
        off = radius * shape - form.form_mm
        exponent = -0.5 * np.einsum("...i,ij,...j->...", off, form.information, off)
        prior = np.exp(-0.5 * square / tilt**2) / tilt**2
        by_hand.append(np.log((np.exp(exponent) * prior).sum()))
    by_hand = np.array(by_hand)
    found = form.log_likelihood(radii, tilt)
    # The closed form drops the slope's own Jacobian of 1 + w with w < 0.05: of the differences
    # between neighbouring radii that is far below a hundredth.
    np.testing.assert_allclose(np.diff(found), np.diff(by_hand), atol=0.02)


def test_best_form_has_the_radius_and_is_the_most_likely(rng):
    (form,) = forms(rng, count=1, tilt_deg=10.0)
    best = form.best_with(30.02)
    assert radius_of_form(best) == pytest.approx(30.02, abs=1e-9)

    def misfit(candidate):
        off = candidate - form.form_mm
        return off @ form.information @ off

    for _ in range(200):
        slope = rng.normal(size=2) * 0.2
        assert misfit(30.02 * form_of_slope(slope)) >= misfit(best) - 1e-6
