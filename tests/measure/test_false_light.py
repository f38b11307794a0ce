"""Single rules by which points are left out: bumps, melted stripes, false backs, foreign pieces."""

import numpy as np
import pytest
import wheel_stripes as ws

from calib import Cause
from measure import reference_profile
from measure.keeping.bumps import bumps
from measure.keeping.cleaning import keep_wheel
from measure.keeping.melted import melted
from measure.keeping.upright import false_back
from measure.laying.by_axle import MOST_TIP_MISFIT_MM
from measure.placing.belonging import can_be_wheel, mostly_wheel
from measure.placing.flange import Voters, find_flanges
from measure.placing.registration import best_shift, refine_shift, tip_misfit_mm
from measure.placing.template import template_of

TEMPLATE = template_of(reference_profile("S1002"))
STEP_MM, SIGMA_MM = 0.3, 0.01
ALONG_MM = np.arange(0.0, 130.0, STEP_MM)
SMOOTH = np.ones(len(ALONG_MM), dtype=bool)


def noisy(outside_mm, rng):
    return outside_mm + rng.normal(0.0, SIGMA_MM, len(outside_mm))


def found(outside_mm, smooth=SMOOTH):
    return bumps(ALONG_MM, outside_mm, np.full(len(ALONG_MM), SIGMA_MM), smooth)


def bell(middle_mm, height_mm, sigma_mm):
    return height_mm * np.exp(-0.5 * ((ALONG_MM - middle_mm) / sigma_mm) ** 2)


@pytest.mark.parametrize("height_mm", [0.3, 1.2])
@pytest.mark.parametrize("worn_mm", [0.0, 8.0])
def test_lump_of_dirt_on_a_worn_tread_is_found_and_little_else(height_mm, worn_mm, rng):
    # As broad as wear is; a lump 3 mm wide beside the deepest place.
    wear = -bell(75.0, worn_mm, 22.0)
    on_bump = found(noisy(wear + bell(80.0, height_mm, 0.8), rng))
    assert on_bump[np.abs(ALONG_MM - 80.0) < 1.0].all()
    assert not on_bump[np.abs(ALONG_MM - 80.0) > 5.0].any()


@pytest.mark.parametrize("worn_mm", [0.0, 3.0, 8.0])
def test_wear_alone_is_no_dirt(worn_mm, rng):
    assert not found(noisy(-bell(75.0, worn_mm, 22.0), rng)).any()


def test_pit_is_no_dirt(rng):
    on_bump = found(noisy(-bell(75.0, 1.0, 1.0), rng))
    assert not on_bump[np.abs(ALONG_MM - 75.0) < 2.0].any()


def test_edge_of_a_worn_face_is_no_dirt(rng):
    # The face has gone by 5 mm between unworn tip and tread.
    worn = -5.0 * ((ALONG_MM > 60.0) & (ALONG_MM < 90.0))
    smooth = (ALONG_MM < 59.0) | (ALONG_MM > 91.0)
    assert not found(noisy(worn, rng), smooth).any()


def test_rise_over_the_reference_on_the_face_is_dirt_if_it_is_narrow(rng):
    smooth = (ALONG_MM < 50.0) | (ALONG_MM > 90.0)
    assert found(noisy(bell(70.0, 1.0, 0.8), rng), smooth)[np.abs(ALONG_MM - 70.0) < 0.8].all()
    # A flange thicker than the reference's is no dirt.
    thick = 2.0 * ((ALONG_MM > 55.0) & (ALONG_MM < 85.0))
    assert not found(noisy(thick, rng), smooth).any()


def test_no_points_have_no_bumps():
    assert len(bumps(*(np.zeros(0),) * 3, np.zeros(0, dtype=bool))) == 0


def straight(count, width_px, *, saturated=False):
    centre = np.column_stack([np.arange(float(count)), np.full(count, 100.0)])
    normal = np.tile([0.0, 1.0], (count, 1))
    plain = ws.make_stripe(centre, normal)
    return type(plain)(
        centre_px=centre,
        normal=normal,
        sigma_px=plain.sigma_px,
        width_px=np.broadcast_to(width_px, count).copy(),
        peak=plain.peak,
        saturated=np.full(count, saturated),
        cause=plain.cause,
    )


def test_stripe_of_one_width_is_not_melted(rng):
    # Rendered wheels: steep faces 0.75 of the usual width, clipped treads 1.25, scatter 0.05.
    width = np.repeat([0.75, 1.0, 1.25], 100) * rng.normal(1.0, 0.03, 300)
    assert not melted(straight(300, width)).any()


def test_where_two_lights_run_into_one_the_points_and_their_neighbours_are_left_out():
    width = np.full(300, 1.3)
    width[100:140] = 2.4
    out = melted(straight(300, width))
    # Three wide ones within 6 px: those up to 4 px aside.
    assert np.flatnonzero(out).tolist() == list(range(96, 144))


def test_single_wide_point_takes_no_neighbours_with_it():
    width = np.full(300, 1.3)
    width[100] = 2.4
    assert np.flatnonzero(melted(straight(300, width))).tolist() == [100]


def laid(rng, *, back_aside_mm=0.0, back_leans=0.0, gap=False):
    points = reference_profile("S1002").points(STEP_MM, back_face_mm=25.0)
    on_back = points[:, 0] <= -70.0 + 1e-6
    below = points[on_back, 1] - TEMPLATE.back_top_mm
    points[on_back, 0] += back_aside_mm + back_leans * below
    if gap:
        points = points[(points[:, 1] < 5.0) | (points[:, 1] > 15.0) | (points[:, 0] > -55.0)]
    return points + rng.normal(0.0, SIGMA_MM, points.shape)


def left_out(points, *, alone=True):
    _, _, nearest = TEMPLATE.place(points)
    return false_back(points, nearest, TEMPLATE, alone=alone), nearest < TEMPLATE.back_count


@pytest.mark.parametrize("gap", [False, True])
@pytest.mark.parametrize("alone", [False, True])
def test_true_back_is_kept_with_and_without_a_gap_above_it(gap, alone, rng):
    out, _ = left_out(laid(rng, gap=gap), alone=alone)
    assert not out.any()


@pytest.mark.parametrize("aside_mm", [-1.9, -0.5, 0.5, 1.9])
def test_back_that_stands_aside_beyond_a_gap_is_none(aside_mm, rng):
    out, on_back = left_out(laid(rng, back_aside_mm=aside_mm, gap=True))
    assert (out == on_back).all()


def test_back_that_leans_is_none(rng):
    # 20 mrad: with the 25 mm of it that is 0.5 mm.
    out, on_back = left_out(laid(rng, back_leans=0.02))
    assert (out == on_back).all()


def test_of_two_faces_the_one_where_the_tip_says_is_the_back(rng):
    points = laid(rng)
    _, _, nearest = TEMPLATE.place(points)
    other = points[nearest < TEMPLATE.back_count] - [1.2, 0.0]
    both = np.concatenate([other, points])
    along, _, nearest = TEMPLATE.place(both)
    order = np.argsort(along, kind="stable")
    out = false_back(both[order], nearest[order], TEMPLATE, alone=False)
    assert set(order[out]) == set(range(len(other)))


def test_another_flange_than_the_references_keeps_its_back_where_nothing_else_is_lit(rng):
    points = reference_profile("LMA").points(STEP_MM, back_face_mm=25.0)
    shift = [0.0, points[:, 1].max() - 28.0]
    out, _ = left_out(points - shift + rng.normal(0.0, SIGMA_MM, points.shape))
    assert not out.any()


def test_piece_that_is_mostly_elsewhere_is_left_out_whole(rng):
    points = laid(rng)
    # A second stripe in one piece: 16 mm lower, but for its back, which lies on the same face.
    false = points - [0.0, 16.0]
    both = np.concatenate([points, false])
    piece = np.repeat([0, 1], [len(points), len(false)])
    along, outside, nearest = TEMPLATE.place(both)
    inside = can_be_wheel(along, outside, nearest, TEMPLATE)
    assert inside[piece == 1].any()
    np.testing.assert_array_equal(mostly_wheel(inside, along, piece, TEMPLATE), piece == 0)


def test_of_two_alike_stripes_the_thinner_is_the_laser(rng):
    points = laid(rng)
    aside = points + [0.0, -20.0]
    both = np.concatenate([points, aside])
    stripe = straight(len(both), np.repeat([2.0, 1.3], [len(points), len(aside)]))
    centre = both / STEP_MM + 400.0
    normal = np.gradient(points, axis=0)[:, ::-1] * [-1.0, 1.0]
    normal = np.tile(normal / np.linalg.norm(normal, axis=1)[:, None], (2, 1))
    stripe = type(stripe)(
        centre_px=centre,
        normal=normal,
        sigma_px=stripe.sigma_px,
        width_px=stripe.width_px,
        peak=stripe.peak,
        saturated=stripe.saturated,
        cause=stripe.cause,
    )
    shifts = [np.array([0.1, 0.1]), np.array([0.1, -19.9])]
    shift = best_shift(both, stripe, shifts, TEMPLATE)
    np.testing.assert_allclose(shift, [0.0, -20.0], atol=0.02)


def test_dimmer_of_two_lights_is_still_a_candidate(rng):
    whole = laid(rng)
    # By another light, whole; by the laser, tip and tread only.
    dim = whole[(whole[:, 0] > -62.0)] + [1.0, 12.0]
    points = np.concatenate([whole, dim])
    tangent = np.concatenate([np.gradient(part, axis=0) for part in (whole, dim)])
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    voters = Voters(points, tangent, np.tile([0.2, 1.0], (len(points), 1)))
    heights = sorted(round(flange.shift_mm[1]) for flange in find_flanges(voters, TEMPLATE))
    assert heights[0] == pytest.approx(0.0, abs=1.0)
    assert heights[-1] == pytest.approx(12.0, abs=1.0)


def test_rough_places_keep_their_points(rng):
    """Where light grazes all points scatter; none of them is wrong."""
    points = reference_profile("S1002").points(STEP_MM, back_face_mm=10.0)
    normal = np.gradient(points, axis=0)[:, ::-1] * [-1.0, 1.0]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    rough = np.where(np.abs(points[:, 0] + 42.0) < 4.0, 0.06, 0.01)
    spread = points + normal * (rough * rng.normal(size=len(points)))[:, None]
    stripe = ws.make_stripe(points / STEP_MM + 400.0, normal)
    kept = keep_wheel(spread, np.full(len(points), SIGMA_MM), stripe, TEMPLATE)
    # Four sigmas, the scatter told from 31 points: a few of a hundred at most.
    assert kept.left_out.get(Cause.OUTLIER, 0) <= 0.03 * len(points)


@pytest.mark.parametrize(
    ("reference", "squeeze", "is_flange"),
    [("S1002", 1.0, True), ("LMA", 1.0, True), ("S1002", 0.6, False), ("S1002", 0.45, False)],
)
def test_tip_out_of_form_is_told_from_the_tip_of_another_flange(reference, squeeze, is_flange, rng):
    points = reference_profile(reference).points(STEP_MM) + [55.0, -28.0]
    points = points * [squeeze, 1.0] - [55.0, -28.0] + rng.normal(0.0, SIGMA_MM, points.shape)
    laid_points = points - refine_shift(points, np.zeros(2), TEMPLATE)
    assert (tip_misfit_mm(laid_points, TEMPLATE) <= MOST_TIP_MISFIT_MM) == is_flange


def test_hidden_tip_is_not_called_out_of_form():
    points = reference_profile("S1002").points(STEP_MM)
    assert tip_misfit_mm(points[points[:, 0] > -30.0], TEMPLATE) == 0.0
