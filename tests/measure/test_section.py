"""The cut by the sheet: mapped by the axle exactly, with derivatives that agree."""

import numpy as np
import pytest
import wheel_stripes as ws

from calib import LaserSensor, LightPlane
from measure.laying.axle import solve_axle
from measure.laying.section import AxleMap, Section, SheetMap, SheetPoints


def exact_section(wheel, sensor, rig):
    """Points of the sheet on a wheel, in the camera, without the camera's picture."""
    profile = wheel.points()
    points, _ = ws.section_in_rig(wheel, profile, sensor, rig)
    return profile[::5], rig.inverse().apply(points[::5])


@pytest.mark.parametrize(("offset_mm", "yaw_deg"), [(0.0, 0.0), (40.0, 3.0), (-73.0, 5.0)])
def test_points_of_an_oblique_cut_have_their_true_place_and_radius(offset_mm, yaw_deg):
    sensor, rig = ws.trackside(yaw_deg=yaw_deg)
    profile, in_cam = exact_section(ws.Wheel(axle_x_mm=offset_mm), sensor, rig)
    section = AxleMap(rig, offset_mm, ws.RADIUS_MM).section(in_cam)
    # The tread of the fine profile is interpolated over 0.05 mm: a micrometre.
    np.testing.assert_allclose(section - [0.0, ws.RADIUS_MM], profile, atol=5e-6)


@pytest.mark.parametrize(
    ("offset_mm", "yaw_deg", "error_mm"),
    [(20.0, 0.0, 0.03), (40.0, 0.0, 0.12), (73.0, 0.0, 0.40)],
)
def test_taken_for_radial_an_oblique_cut_would_be_wrong_by_the_known_amount(
    offset_mm, yaw_deg, error_mm
):
    # A sheet below the horizon by 30 degrees: an axle off by x lies x / 2 off the sheet.
    sensor, rig = ws.trackside(yaw_deg=yaw_deg)
    profile, in_cam = exact_section(ws.Wheel(axle_x_mm=2.0 * offset_mm), sensor, rig)
    in_rig = rig.apply(in_cam)
    outward = np.array([np.cos(np.radians(30.0)), 0.0, -np.sin(np.radians(30.0))])
    z = in_rig @ outward
    tip, tread = np.argmax(profile[:, 1]), np.argmin(np.abs(profile[:, 0]))
    # Quoted to 0.01 mm in the table of wheel facts.
    assert z[tip] - z[tread] - 28.0 == pytest.approx(error_mm, abs=0.015)


@pytest.mark.parametrize("kind", ["axle", "sheet"])
def test_jacobian_agrees_with_differences(kind, rng):
    sensor, rig = ws.trackside()
    _, in_cam = exact_section(ws.Wheel(), sensor, rig)
    in_cam = in_cam[:: len(in_cam) // 20]
    section_map = (
        AxleMap(rig, 7.0, 411.0)
        if kind == "axle"
        else SheetMap.in_plane(sensor.plane, 0.3, mirrored=True)
    )
    jacobian = section_map.jacobian(in_cam)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-4
        slope = (section_map.section(in_cam + step) - section_map.section(in_cam - step)) / 2e-4
        np.testing.assert_allclose(jacobian[:, :, axis], slope, atol=1e-8)


@pytest.mark.parametrize("axle_x_mm", [-60.0, -5.0, 0.0, 30.0, 60.0])
@pytest.mark.parametrize("radius_mm", [405.0, 420.0])
def test_axle_is_solved_from_the_tread_it_rolls_on(axle_x_mm, radius_mm):
    sensor, rig = ws.trackside()
    wheel = ws.Wheel(axle_x_mm=axle_x_mm, radius_mm=radius_mm)
    profile, in_cam = exact_section(wheel, sensor, rig)
    tread = rig.apply(in_cam)[np.argmin(np.abs(profile[:, 0]))][[0, 2]]
    mounting = ws.mounting_of(rig, sigma_radius_mm=10.0)
    axle = solve_axle(tread[None], mounting, 0.0)
    # The tread lies on the found circle: that much one point can tell, held to 1 mm by the rail
    # and pulled by priors of 10 and 60 mm, three of whose sigmas here make 0.03 mm.
    place = np.hypot(*(tread - [axle.x_mm, axle.z_mm]))
    assert place == pytest.approx(axle.z_mm, abs=0.05)
    # The rest, along the line of equal tread, is within what its covariance says: 2.5 sigma.
    off = np.array([axle.x_mm - axle_x_mm, axle.z_mm - radius_mm])
    assert off @ np.linalg.solve(axle.covariance, off) < 2.5**2


def test_pixels_that_miss_the_sheet_are_left_out():
    sensor, _ = ws.trackside()
    # This sheet runs away from the camera to a horizon at y / z = 0.1, row 786 of the picture.
    plane = LightPlane.from_coefficients([0.0, 1.0, -0.1, -30.0])
    rows = np.array([[1000.0, 400.0], [1000.0, 1000.0]])
    stripe = ws.make_stripe(rows, np.array([[0.0, 1.0], [0.0, 1.0]]))
    seen = SheetPoints.of(stripe, LaserSensor.exact(sensor.camera, plane))
    np.testing.assert_allclose(seen.stripe.centre_px, rows[1:])


def test_sigma_across_the_profile_is_that_of_scattered_points(rng):
    sensor, rig = ws.trackside()
    clean = ws.stripe_on(ws.Wheel(), sensor, rig)
    section_map = AxleMap(rig, 0.0, ws.RADIUS_MM)
    predicted = Section.of(SheetPoints.of(clean, sensor), section_map)
    tree_normal = np.column_stack([-predicted.tangent[:, 1], predicted.tangent[:, 0]])
    draws = []
    for _ in range(200):
        noisy = clean.centre_px + clean.normal * rng.normal(0.0, 0.05, (len(clean), 1))
        points = section_map.section(sensor.locate(noisy))
        draws.append(
            np.sum(
                (points - section_map.section(sensor.locate(clean.centre_px))) * tree_normal, axis=1
            )
        )
    scatter = np.std(draws, axis=0)
    # 200 draws pin each of 700 standard deviations to 5 %; their mean ratio to 0.2 %.
    assert np.mean(scatter / predicted.sigma_mm) == pytest.approx(1.0, abs=0.01)
