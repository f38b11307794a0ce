"""Is the radius of a cylinder found from its section, and is its uncertainty true?

Sections are traced in space from a known cylinder, and drawn inwards as a blur draws them.
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import PAPER_SENSOR

from calib import Cause, LaserSensor, SheetFrame, StripePoints, judge_cylinder
from calib.judging.arc import points_of_arc
from calib.judging.section import (
    distances,
    fit_section,
    form_of_slope,
    radius_of_form,
    slope_of_form,
)
from calib.seeing.stripe import kernel_of

RADIUS_MM = 30.0
WIDTH_PX = 1.2
SENSOR = PAPER_SENSOR
NORMAL = SENSOR.plane.normal_in_cam
MIDDLE = SENSOR.locate(np.array([[700.0, 300.0]]))[0]


def tilted_axis(degrees, towards=0.7):
    along = np.cross(NORMAL, [1.0, 0.0, 0.0])
    along /= np.linalg.norm(along)
    across = np.cross(NORMAL, along)
    lean = np.cos(towards) * along + np.sin(towards) * across
    tilt = np.radians(degrees)
    return np.cos(tilt) * NORMAL + np.sin(tilt) * lean


def section_px(axis, angle):
    """Where the camera sees points of the section, at angles around the axis."""
    one = np.cross(axis, [0.0, 0.0, 1.0])
    one /= np.linalg.norm(one)
    other = np.cross(axis, one)
    rim = MIDDLE + RADIUS_MM * (np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other))
    along = -SENSOR.plane.distance_mm(rim) / (NORMAL @ axis)
    return SENSOR.camera.project(rim + np.outer(along, axis))


def facing_angle(axis):
    """The angle at which the section faces the camera."""
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    one = np.cross(axis, [0.0, 0.0, 1.0])
    one /= np.linalg.norm(one)
    other = np.cross(axis, one)
    outward = np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)
    return angle[np.argmin(outward @ MIDDLE)]


def stripe_on(axis, *, count=60, reach_deg=70.0, noise_px=0.0, rng=None):
    angle = facing_angle(axis) + np.radians(np.linspace(-reach_deg, reach_deg, count))
    before, here, after = (section_px(axis, angle + shift) for shift in (-1e-3, 0.0, 1e-3))
    tangent = after - before
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    bend = (after - 2.0 * here + before) / (np.linalg.norm(tangent, axis=1) / 2.0)[:, None] ** 2
    width = np.full(count, WIDTH_PX)
    pull = 0.5 * (kernel_of(width) ** 2 + width**2)
    shift = noise_px * rng.normal(size=count) if rng is not None else np.zeros(count)
    return points_at(here + pull[:, None] * bend + shift[:, None] * normal, normal, noise_px)


def points_at(centre, normal, sigma_px=0.0, width_px=WIDTH_PX):
    count = len(centre)
    return StripePoints(
        centre_px=centre,
        normal=normal,
        sigma_px=np.full(count, max(sigma_px, 1e-3)),
        width_px=np.full(count, width_px),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def joined(*parts):
    return StripePoints(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("centre_px", "normal", "sigma_px", "width_px", "peak", "saturated")
        },
        cause=sum((part.cause for part in parts), ()),
    )


@pytest.mark.parametrize("tilt_deg", [0.0, 3.0, 12.0, 25.0])
def test_radius_is_exact_where_the_axis_is_known(tilt_deg):
    axis = tilted_axis(tilt_deg)
    reading = judge_cylinder(stripe_on(axis), SENSOR, RADIUS_MM, name="one", axis_in_cam=axis)
    assert reading.reason == ""
    # Half of a second-order difference of the bend along the arc stays: some 1e-4 px.
    assert reading.radius_mm == pytest.approx(RADIUS_MM, abs=5e-4)
    assert reading.tilt_deg == pytest.approx(tilt_deg, abs=1e-6)


@pytest.mark.parametrize("tilt_deg", [8.0, 20.0])
def test_radius_and_tilt_are_found_together_without_noise(tilt_deg):
    reading = judge_cylinder(stripe_on(tilted_axis(tilt_deg)), SENSOR, RADIUS_MM, name="one")
    # The free axis magnifies what stays twentyfold.
    assert reading.radius_mm == pytest.approx(RADIUS_MM, abs=0.01)
    assert reading.tilt_deg == pytest.approx(tilt_deg, abs=0.2)


def test_uncertainty_is_the_scatter_where_the_axis_is_known(rng):
    axis = tilted_axis(10.0)
    readings = [
        judge_cylinder(
            stripe_on(axis, count=45, noise_px=0.1, rng=rng),
            SENSOR,
            RADIUS_MM,
            name="",
            axis_in_cam=axis,
        )
        for _ in range(36)
    ]
    assert {reading.reason for reading in readings} == {""}
    scatter = np.std([reading.radius_mm for reading in readings], ddof=1)
    predicted = np.mean([reading.u95_mm for reading in readings]) / 1.96
    # So few points are too far apart to share noise. 36 draws pin a scatter to 12 %.
    assert predicted == pytest.approx(scatter, rel=0.3)


def test_free_axis_is_told_to_be_much_more_uncertain(rng):
    axis = tilted_axis(10.0)
    stripe = stripe_on(axis, noise_px=0.05, rng=rng)
    free = judge_cylinder(stripe, SENSOR, RADIUS_MM, name="")
    known = judge_cylinder(stripe, SENSOR, RADIUS_MM, name="", axis_in_cam=axis)
    assert free.u95_mm > 4.0 * known.u95_mm


def test_doubt_of_the_sensor_is_in_the_uncertainty(rng):
    axis = tilted_axis(10.0)
    stripe = stripe_on(axis, noise_px=0.01, rng=rng)
    doubt = np.zeros((13, 13))
    doubt[12, 12] = 0.5**2
    unsure = LaserSensor(SENSOR.camera, SENSOR.plane, doubt)
    reading = judge_cylinder(stripe, unsure, RADIUS_MM, name="", axis_in_cam=axis)
    # The section grows with the distance of the sheet from the camera.
    expected = 1.96 * 0.5 / SENSOR.plane.offset_mm * RADIUS_MM
    assert reading.u95_mm == pytest.approx(expected, rel=0.05)


def test_straight_edges_and_wide_ones_are_not_taken_for_the_section(rng):
    axis = tilted_axis(10.0)
    stripe = stripe_on(axis, noise_px=0.02, rng=rng)
    place = np.linspace(200.0, 1800.0, 300)
    edge = points_at(
        np.column_stack([place, 300.0 + 0.3 * place]), np.tile([-0.287, 0.958], (300, 1))
    )
    lamp = points_at(stripe.centre_px[-8:] + 8.0, stripe.normal[-8:], width_px=6.0)
    alone = judge_cylinder(stripe, SENSOR, RADIUS_MM, name="", axis_in_cam=axis)
    among = judge_cylinder(joined(edge, stripe, lamp), SENSOR, RADIUS_MM, name="", axis_in_cam=axis)
    assert among.radius_mm == pytest.approx(alone.radius_mm, abs=0.01)


def test_edge_that_touches_the_section_is_not_taken_along_for_it():
    stripe = stripe_on(tilted_axis(10.0), count=240)
    # It runs on along the stripe's last direction, near the section, and is much wider but for
    # a few points.
    along = stripe.centre_px[-1] - stripe.centre_px[-2]
    along /= np.linalg.norm(along)
    edge = stripe.centre_px[-1] + np.outer(np.arange(3.0, 60.0), along)
    edge = points_at(edge, np.tile(stripe.normal[-1], (len(edge), 1)), width_px=6.0)
    width = edge.width_px.copy()
    width[11:15] = 2.0
    picked, _ = points_of_arc(
        joined(stripe, replace(edge, width_px=width)),
        SENSOR,
        SheetFrame.of(SENSOR.plane),
        RADIUS_MM,
    )
    assert picked[: len(stripe)].sum() > 0.9 * len(stripe)
    assert not picked[len(stripe) :].any()


def test_only_the_lasers_own_points_on_the_section_are_picked():
    stripe = stripe_on(tilted_axis(10.0))
    fading = replace(stripe.select(np.arange(5)), peak=np.full(5, 20.0))
    lamp = points_at(stripe.centre_px[-8:], stripe.normal[-8:], width_px=6.0)
    # Scratches across the stripe: on the section, but not along it.
    across = np.column_stack([-stripe.normal[:, 1], stripe.normal[:, 0]])[20:40]
    scratches = points_at(stripe.centre_px[20:40], across)
    picked, _ = points_of_arc(
        joined(stripe, fading, lamp, scratches), SENSOR, SheetFrame.of(SENSOR.plane), RADIUS_MM
    )
    np.testing.assert_array_equal(picked, np.arange(len(picked)) < len(stripe))


def test_wrong_axis_is_recognised(rng):
    stripe = stripe_on(tilted_axis(25.0), noise_px=0.02, rng=rng)
    reading = judge_cylinder(stripe, SENSOR, RADIUS_MM, name="", axis_in_cam=NORMAL)
    assert "the axis is another one" in reading.reason
    assert np.isnan(reading.radius_mm)


@pytest.mark.parametrize(
    ("stripe", "said"),
    [
        (points_at(np.empty((0, 2)), np.empty((0, 2))), "0 stripe points"),
        (stripe_on(NORMAL, reach_deg=15.0), "degrees of the section"),
    ],
)
def test_what_is_no_section_is_refused_with_a_reason(stripe, said):
    reading = judge_cylinder(stripe, SENSOR, RADIUS_MM, name="one")
    assert said in reading.reason
    assert np.isnan(reading.radius_mm)


def test_jacobian_of_the_distance_is_its_slope(rng):
    points = rng.normal(size=(20, 2)) * 5.0 + [30.0, 0.0]
    at = np.array([1.0, 2.0, 28.0, 1.2, -0.9])
    _, jacobian = distances(points, at[:2], at[2:], RADIUS_MM)
    for place in range(5):
        step = np.zeros(5)
        step[place] = 1e-5
        ahead, behind = at + step, at - step
        slope = distances(points, ahead[:2], ahead[2:], RADIUS_MM)[0]
        slope = (slope - distances(points, behind[:2], behind[2:], RADIUS_MM)[0]) / 2e-5
        np.testing.assert_allclose(jacobian[:, place], slope, atol=1e-8)


@pytest.mark.parametrize("slope", [[0.0, 0.0], [0.3, 0.0], [-0.1, 0.25], [0.0, -0.4]])
def test_form_tells_radius_and_slope_but_for_its_sign(slope):
    form = RADIUS_MM * form_of_slope(np.array(slope))
    assert radius_of_form(form) == pytest.approx(RADIUS_MM, abs=1e-9)
    found = slope_of_form(form)
    np.testing.assert_allclose(np.outer(found, found), np.outer(slope, slope), atol=1e-9)


def test_points_on_a_tilted_cylinders_section_have_no_distance(rng):
    # Points of the mantle (R cos a, R sin a, h) turned so that the axis is (p, q, 1).
    slope = np.array([0.2, -0.35])
    axis = np.append(slope, 1.0) / np.sqrt(1.0 + slope @ slope)
    arm = rng.normal(size=(50, 2))
    flat = np.column_stack([arm, np.zeros(50)])
    reach = np.linalg.norm(flat - np.outer(flat @ axis, axis), axis=1)
    points = arm / reach[:, None] * RADIUS_MM
    form = RADIUS_MM * form_of_slope(slope)
    np.testing.assert_allclose(distances(points, np.zeros(2), form, RADIUS_MM)[0], 0.0, atol=1e-9)


def test_form_owes_to_the_points_what_refitting_says(rng):
    angle = np.linspace(-1.2, 1.2, 80)
    points = RADIUS_MM * np.column_stack([np.cos(angle), 1.05 * np.sin(angle)])
    points += rng.normal(size=points.shape) * 0.003
    sigma = np.full(len(points), 0.003)
    start = np.array([RADIUS_MM, 0.0, 0.0])
    fit = fit_section(points, sigma, np.zeros(2), start, unit_mm=RADIUS_MM)
    moved = points.copy()
    shift = 1e-4
    moved[40] += shift * points[40] / np.linalg.norm(points[40])
    again = fit_section(moved, sigma, fit.centre_mm, fit.form_mm, unit_mm=RADIUS_MM)
    change = (again.form_mm - fit.form_mm) / shift
    # The other points' weights follow a little: to second order.
    np.testing.assert_allclose(change, fit.form_by_residual[:, 40], rtol=0.05)
