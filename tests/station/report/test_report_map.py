"""The map of the sheet is true to scale, without a gap, and names the sensor's own figures."""

import numpy as np
import pytest
from page_reading import read_page
from report_samples import by_hand

from station.report import calibration_report
from station.report.evidence import evidence_of
from station.report.sheet_map import SheetFrame, _runs
from station.report.wording import figures


def test_distances_on_the_map_are_those_on_the_sheet(kept, rng):
    sensor = kept.document.laser_sensor()
    frame = SheetFrame.at(sensor, np.array([1000.0, 500.0]))
    points_mm = sensor.locate(rng.uniform([200, 200], [1800, 900], (50, 2)))
    # Rounding of lengths of some 500 mm.
    np.testing.assert_allclose(
        np.linalg.norm(np.diff(frame.place(points_mm), axis=0), axis=1),
        np.linalg.norm(np.diff(points_mm, axis=0), axis=1),
        atol=1e-9,
    )


def test_map_runs_right_and_down_as_pictures_do(kept):
    sensor = kept.document.laser_sensor()
    frame = SheetFrame.at(sensor, np.array([1000.0, 500.0]))
    middle, right, down = frame.place(
        sensor.locate(np.array([[1000.0, 500.0], [1100.0, 500.0], [1000.0, 600.0]]))
    )
    np.testing.assert_allclose(middle, 0.0, atol=1e-9)
    assert right[0] > 0.0
    assert down[1] > 0.0


@pytest.mark.parametrize("shades", [1, 2])
def test_runs_of_one_shade_hold_every_cell_once(rng, shades):
    shade = rng.integers(0, shades, 360)
    runs = list(_runs(shade))
    cells = [cell for first, last in runs for cell in range(first, last + 1)]
    assert cells == list(range(360))
    assert all(len({*shade[first : last + 1].tolist()}) == 1 for first, last in runs)
    assert all(first // 120 == last // 120 for first, last in runs), "a run goes round a corner"


def test_range_that_is_named_is_that_of_the_sensor_at_the_stripes(kept):
    sets = [picture.stripe for picture in evidence_of(kept.points_csv)]
    stripe_px = np.vstack([points.corrected_px[points.used] for points in sets])
    sigma_mm = kept.document.laser_sensor().sigma_on_sheet(stripe_px)
    said = f"between {figures(sigma_mm.min())} and {figures(sigma_mm.max())} mm"
    assert said in read_page(kept.page).text


@pytest.mark.parametrize("known_mm", [0.0, 1e-3])
def test_sheet_known_evenly_or_exactly_is_drawn_too(kept, known_mm):
    document, points = by_hand(kept, [0.1, 0.1])
    covariance = np.zeros((13, 13))
    covariance[12, 12] = known_mm**2
    document = document.model_copy(
        update={"sensor_covariance": tuple(map(tuple, covariance.tolist()))}
    )
    page = read_page(calibration_report(document, points))
    assert any("shade-" in path.attributes.get("class", "") for path in page.all("path"))


def test_page_without_a_stripe_says_so(kept):
    document, points = by_hand(kept, [0.1, 0.1], stripe=0)
    assert "No stripe point was used." in read_page(calibration_report(document, points)).text
