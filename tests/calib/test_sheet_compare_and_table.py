"""Two sensors side by side, the frame of the sheet, and the sheet as a table."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import PAPER_CAMERA, PAPER_PLANE, PAPER_SENSOR

from calib import (
    CameraMismatch,
    LaserSensor,
    LightPlane,
    SheetFrame,
    SheetTable,
    compare_sensors,
    pixel_grid,
)

FIELD = pixel_grid(2048, 1088, 64)
DOUBT = np.zeros((13, 13))
DOUBT[12, 12] = 0.1**2


def at_offset(offset_mm, covariance=DOUBT):
    plane = LightPlane(PAPER_PLANE.normal_in_cam, offset_mm)
    return LaserSensor(PAPER_CAMERA, plane, covariance)


def test_sensor_agrees_with_itself():
    comparison = compare_sensors(PAPER_SENSOR, PAPER_SENSOR, FIELD)
    assert comparison.rms_mm == 0.0
    assert comparison.agree


def test_difference_is_that_of_the_points_and_largest_where_they_are_farthest():
    offset = PAPER_PLANE.offset_mm
    comparison = compare_sensors(at_offset(offset), at_offset(1.001 * offset), FIELD)
    distance = np.linalg.norm(PAPER_SENSOR.locate(FIELD), axis=1)
    np.testing.assert_allclose(comparison.difference_mm, 1e-3 * distance, rtol=1e-9)
    assert comparison.worst == np.nanargmax(distance)
    np.testing.assert_allclose(
        comparison.sigma_mm, np.sqrt(2.0) * 0.1 / offset * distance, rtol=1e-9
    )


def test_calibrations_that_differ_by_their_own_scatter_are_told_apart_one_time_in_twenty(rng):
    offset = PAPER_PLANE.offset_mm
    agreeing = [
        compare_sensors(
            at_offset(offset + rng.normal() * 0.1), at_offset(offset + rng.normal() * 0.1), FIELD
        ).agree
        for _ in range(400)
    ]
    # One degree of freedom, the worst case of the bound: 95 % of 400, three deviations of 1.1 %.
    assert np.mean(agreeing) == pytest.approx(0.95, abs=0.033)


def test_cameras_of_different_size_are_not_compared():
    smaller = replace(PAPER_CAMERA, width=1024)
    with pytest.raises(CameraMismatch, match="2048 x 1088 px and of 1024 x 1088"):
        compare_sensors(PAPER_SENSOR, LaserSensor.exact(smaller, PAPER_PLANE), FIELD)


def test_empty_field_has_no_difference():
    assert np.isnan(compare_sensors(PAPER_SENSOR, PAPER_SENSOR, np.empty((0, 2))).rms_mm)


@pytest.mark.parametrize("normal", [[0.3, 0.9, -0.3], [1.0, 0.01, 0.0], [0.0, 0.0, -1.0]])
def test_sheet_coordinates_are_distances_on_the_sheet(rng, normal):
    plane = LightPlane.from_coefficients([*normal, 300.0])
    frame = SheetFrame.of(plane)
    places = rng.normal(size=(30, 2)) * 100.0
    points = frame.points(places)
    np.testing.assert_allclose(plane.distance_mm(points), 0.0, atol=1e-9)
    np.testing.assert_allclose(frame.coordinates(points), places, atol=1e-9)
    away = np.cross(*frame.axes_in_cam)
    np.testing.assert_allclose(away, -plane.normal_in_cam, atol=1e-12)


def test_slope_of_the_normal_is_none():
    frame = SheetFrame.of(PAPER_PLANE)
    np.testing.assert_allclose(frame.slope_of(PAPER_PLANE.normal_in_cam), 0.0, atol=1e-12)
    with pytest.raises(ValueError, match="leave the sheet"):
        frame.slope_of(frame.axes_in_cam[0])


def test_axes_that_are_not_square_are_refused():
    with pytest.raises(ValueError, match="square"):
        SheetFrame(np.zeros(3), np.array([[1.0, 0.0, 0.0], [0.1, 1.0, 0.0]]))


def test_table_holds_what_the_sensor_says_of_each_pixel():
    sensor = at_offset(PAPER_PLANE.offset_mm)
    table = SheetTable.of(sensor, 200)
    assert (table.u_px[0], table.u_px[-1], table.v_px[-1]) == (0.0, 2047.0, 1087.0)
    pixel = np.array([[table.u_px[4], table.v_px[2]]])
    point = sensor.locate(pixel)[0]
    np.testing.assert_allclose(table.in_cam_mm[2, 4], point, rtol=1e-12)
    np.testing.assert_allclose(table.frame.points(table.sheet_mm[2, 4]), point, atol=1e-9)
    np.testing.assert_allclose(table.sigma_mm[2, 4], sensor.sigma_on_sheet(pixel)[0], rtol=1e-12)


def test_table_in_blocks_of_rows_is_whole():
    table = SheetTable.of(PAPER_SENSOR, 16)
    assert table.sigma_mm.shape == (len(table.v_px), len(table.u_px))
    assert (np.diff(table.v_px) > 0.0).all()


def test_table_of_no_step_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        SheetTable.of(PAPER_SENSOR, 0)
