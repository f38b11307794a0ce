"""Gauges on exact curves: values, gradients, and what is missing stays missing."""

import numpy as np
import pytest

from measure import Quantity, Status, reference_profile
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.gauges import gauge
from measure.gauging.localfit import LocalFit

S1002 = reference_profile("S1002")


def curve_of(points, window_mm=3.0, sigma_mm=0.005):
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return Curve(points, along, np.full(len(points), sigma_mm), window_mm)


def gauged(points, window_mm=3.0, status=Status.OK):
    back = Found(Estimate.exact(-70.0, len(points)), status)
    return gauge(curve_of(points, window_mm), back, S1002)


def values(points, window_mm=3.0):
    return {q: f.estimate.value for q, f in gauged(points, window_mm).found.items()}


@pytest.mark.parametrize("window_mm", [1.3, 3.0])
@pytest.mark.parametrize("name", ["S1002", "LMA"])
def test_a_reference_reads_its_own_nominal_values(name, window_mm):
    reference = reference_profile(name)
    read = values(reference.points(0.25, back_face_mm=20.0), window_mm)
    for quantity, nominal in reference.nominal.items():
        # Parabolas of 3 mm half-width on R = 12 are off by 0.5 um; where two arcs meet, by more.
        assert read[quantity] == pytest.approx(nominal, abs=2.5e-3)


def test_one_tenth_of_a_degree_of_roll_lowers_the_flange_height_by_a_tenth():
    points = S1002.points(0.25, back_face_mm=20.0)
    angle = np.radians(0.1)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = gauged(points).found[Quantity.FLANGE_HEIGHT].estimate
    # y of the tip is -55: 55 mm x 1.745e-3 = 0.096 mm.
    assert found.moved_by(points @ turn.T - points) == pytest.approx(-0.096, abs=0.002)
    turned = values(points @ turn.T)[Quantity.FLANGE_HEIGHT]
    assert turned - found.value == pytest.approx(-0.096, abs=0.002)


@pytest.mark.parametrize("quantity", list(S1002.nominal))
def test_gradients_predict_the_effect_of_moving_points(quantity, rng):
    points = S1002.points(0.25, back_face_mm=20.0)
    motion = rng.normal(0.0, 1e-4, points.shape)
    found = gauged(points).found[quantity].estimate
    after = gauged(points + motion).found[quantity].estimate
    # The effect itself is near 5e-5 mm; what the gradient leaves is of second order.
    assert found.moved_by(motion) == pytest.approx(after.value - found.value, abs=3e-6)


def test_an_error_of_the_flange_back_goes_into_the_thickness_one_to_one():
    points = S1002.points(0.25, back_face_mm=20.0)
    moved = gauge(curve_of(points), Found(Estimate.exact(-69.9, len(points)), Status.OK), S1002)
    before = values(points)[Quantity.FLANGE_THICKNESS_12]
    after = moved.found[Quantity.FLANGE_THICKNESS_12].estimate.value
    # 0.1 mm, and what the tread (1 in 30 here) adds through the face (0.364): 1.2 um.
    assert after - before == pytest.approx(-0.1, abs=0.003)


def test_an_assumed_flange_back_shows_in_every_status():
    found = gauged(S1002.points(0.25, back_face_mm=20.0), status=Status.REFERENCE_ASSUMED).found
    assert {f.status for f in found.values()} == {Status.REFERENCE_ASSUMED}


def test_a_tread_that_ends_just_before_the_tape_circle_is_extrapolated():
    points = S1002.points(0.25, back_face_mm=20.0)
    found = gauged(points[points[:, 0] < -1.0]).found
    assert found[Quantity.FLANGE_HEIGHT].status is Status.EXTRAPOLATED
    # The tread's slope, 1 in 30, changes by 3e-3 a millimetre: a parabola follows it.
    assert found[Quantity.FLANGE_HEIGHT].estimate.value == pytest.approx(28.0, abs=0.01)


def test_a_tread_that_ends_well_before_it_gives_nothing():
    points = S1002.points(0.25, back_face_mm=20.0)
    assert gauged(points[points[:, 0] < -8.0]).found == {}


def test_a_gap_in_the_flange_face_takes_the_thickness_and_leaves_the_height():
    points = S1002.points(0.25, back_face_mm=20.0)
    y, z = points.T
    hole = (y > -50.0) & (z > 4.0) & (z < 20.0)
    found = gauged(points[~hole]).found
    assert Quantity.FLANGE_HEIGHT in found
    assert Quantity.FLANGE_THICKNESS_10 not in found


@pytest.mark.parametrize("hole_mm", [(11.4, 18.0), (6.0, 12.6), (9.0, 15.0)])
def test_no_reading_leans_on_a_fit_across_a_gap(hole_mm):
    points = S1002.points(0.25, back_face_mm=20.0)
    y, z = points.T
    hole = (y > -50.0) & (z > hole_mm[0]) & (z < hole_mm[1])
    found = gauged(points[~hole]).found.get(Quantity.FLANGE_THICKNESS_12)
    if found is not None:
        assert found.status is Status.EXTRAPOLATED
        off = found.estimate.value - S1002.nominal[Quantity.FLANGE_THICKNESS_12]
        # Three of the sigmas that are owned up to for what lies in the gap.
        assert abs(off) < 3.0 * found.blind_mm + 0.01


def test_a_small_gap_is_bridged_and_said_to_be():
    points = S1002.points(0.25, back_face_mm=20.0)
    y, z = points.T
    hole = (y > -50.0) & (z > 11.0) & (z < 13.5)
    found = gauged(points[~hole]).found[Quantity.FLANGE_THICKNESS_12]
    assert found.status is Status.EXTRAPOLATED
    # 1.1 mm from the nearest point; 0.04 mm a square millimetre, turned by the face's slope.
    assert found.blind_mm == pytest.approx(0.05, abs=0.02)
    off = found.estimate.value - S1002.nominal[Quantity.FLANGE_THICKNESS_12]
    assert abs(off) < 2.0 * found.blind_mm


def test_a_wide_gap_is_not_fitted_across():
    s = np.concatenate([np.arange(-9.0, -4.0, 0.25), np.arange(4.0, 9.0, 0.25)])
    assert curve_of(np.column_stack([s, 0.1 * s])).fit(np.zeros(2)) is None


def test_without_a_flange_there_is_no_datum():
    points = S1002.points(0.25)
    assert gauged(points[points[:, 0] > -34.0]) is None


def test_hollow_is_its_depth_below_the_field_side():
    y, z = S1002.points(0.25, back_face_mm=20.0).T
    depth = 3.0 * np.exp(-0.5 * (y / 12.0) ** 2)
    worn = np.column_stack([y, z - depth])
    on_tread = (y > -14.0) & (y < 56.0)
    level = worn[on_tread, 1]
    truth = (level - np.minimum.accumulate(level)).max()
    # The tread is averaged over 9 mm around its lowest and highest place.
    assert values(worn)[Quantity.HOLLOW_DEPTH] == pytest.approx(truth, abs=0.02)
    assert values(np.column_stack([y, z]))[Quantity.HOLLOW_DEPTH] == 0.0


def test_greatest_wear_is_found_where_it_is():
    y, z = S1002.points(0.25, back_face_mm=20.0).T
    bump = 2.0 * np.exp(-0.5 * ((y - 20.0) / 15.0) ** 2)
    result = gauged(np.column_stack([y, z - bump]))
    # Nine millimetres are averaged: a parabola misses 2 mm x (w / 15)^4 x 3/280, 0.002.
    wear = result.found[Quantity.TREAD_WEAR_MAX].estimate.value
    assert wear == pytest.approx(2.0, abs=0.02)
    assert result.wear_max_at_d_mm == pytest.approx(90.0, abs=1.5)


def test_a_tread_without_a_hollow_has_one_of_nothing_give_or_take():
    points = S1002.points(0.25, back_face_mm=20.0)
    hollow = gauged(points).found[Quantity.HOLLOW_DEPTH]
    # Of two means over 12 mm, 48 points each: 1.5 x sqrt(2 / 48) of a point's own scatter.
    sigma = np.linalg.norm(hollow.estimate.gradient)
    assert hollow.estimate.value == 0.0
    assert sigma == pytest.approx(1.5 * np.sqrt(2.0 / 48.0), rel=0.25)


def test_the_throat_beside_it_does_not_move_the_greatest_wear():
    y, z = S1002.points(0.25, back_face_mm=20.0).T
    bump = 2.0 * np.exp(-0.5 * ((y + 6.0) / 30.0) ** 2) * (y > -40.0)
    result = gauged(np.column_stack([y, z - bump]))
    # Lines over 8 mm to either side, cut short at the end of the tread, lean by 2 mm; the tread
    # itself, bent by the throat, would have it at the very end, 8 mm away.
    assert result.wear_max_at_d_mm == pytest.approx(64.0, abs=2.5)
    assert result.found[Quantity.TREAD_WEAR_MAX].estimate.value == pytest.approx(2.0, abs=0.01)


def test_a_sharp_edge_is_followed_by_a_narrower_window():
    s = np.linspace(-6.0, 6.0, 241)
    points = np.column_stack([s, -np.abs(s) * 0.5])
    wide = LocalFit.around(points, np.ones(len(s)), np.zeros(2), 3.0)
    chosen = curve_of(points).fit(np.zeros(2))
    assert abs(chosen.distance_mm(np.zeros(2))) < abs(wide.distance_mm(np.zeros(2)))


def test_too_few_points_are_no_fit():
    assert LocalFit.around(np.zeros((3, 2)), np.ones(3), np.zeros(2), 3.0) is None
