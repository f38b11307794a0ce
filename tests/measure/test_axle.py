"""What is not known of the axle: which cause moves it, and what several pictures share of it."""

import numpy as np
import pytest
import wheel_stripes as ws

from measure import Quantity, WheelFrame, measure_wheel, reference_profile
from measure.laying.axle import solve_axle

SENSOR, RIG = ws.trackside()
TREAD_MM = np.array([363.0, 210.0])
BELOW_MM = np.array([0.0, 0.0])


def solved(tread_mm=TREAD_MM, *, radial_x_mm=0.0, radius_mm=420.0, **sigmas):
    mounting = ws.Mounting(RIG, wheel_radius_mm=radius_mm, **sigmas)
    axle = solve_axle(tread_mm[None], mounting, radial_x_mm)
    return np.array([axle.x_mm, axle.z_mm]), axle


@pytest.mark.parametrize("tread_mm", [TREAD_MM, BELOW_MM], ids=["from the side", "from below"])
def test_each_cause_moves_the_axle_as_is_said(tread_mm):
    at, axle = solved(tread_mm)
    by_place = solved(tread_mm, radial_x_mm=0.6)[0] - at
    by_radius = solved(tread_mm, radius_mm=420.1)[0] - at
    # A hundredth of each sigma: first order.
    np.testing.assert_allclose(by_place, 0.01 * axle.by_place_mm, rtol=0.02, atol=2e-4)
    np.testing.assert_allclose(by_radius, 0.01 * axle.by_radius_mm, rtol=0.02, atol=2e-4)


def test_height_of_the_tread_moves_the_axle_as_is_said():
    # Were the tread where the rail is 0.01 mm lower, its distance would miss the radius by that.
    _, axle = solved(sigma_radius_mm=1e-3, sigma_axle_x_mm=1e6)
    outward = TREAD_MM - [axle.x_mm, axle.z_mm]
    slope = outward[0] / np.hypot(*outward)
    assert abs(axle.by_height_mm[0]) == pytest.approx(1.0 / abs(slope), rel=1e-3)


def test_a_sheet_from_below_knows_the_place_no_better_than_before():
    _, axle = solved(BELOW_MM)
    assert np.hypot.reduce([axle.by_place_mm[0], axle.by_radius_mm[0]]) == pytest.approx(60.0)


def test_what_the_rail_is_off_no_number_of_pictures_from_one_place_averages(rng):
    mounting = ws.mounting_of(
        RIG, sigma_radius_mm=0.01, sigma_axle_direction_rad=1e-7, sigma_height_mm=4.0
    )
    wheel = ws.Wheel(axle_x_mm=80.0)
    frames = [WheelFrame(ws.stripe_on(wheel, SENSOR, RIG, rng), n, "test") for n in range(6)]
    alone, together = (
        measure_wheel(some, SENSOR, reference_profile("S1002"), mounting=mounting)
        for some in (frames[:1], frames)
    )
    height = Quantity.FLANGE_HEIGHT
    # The wheel is as far off its height in all of them: 4 mm here, its noise far below.
    assert together.readings[height].u95 > 0.9 * alone.readings[height].u95
