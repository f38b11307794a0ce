"""Are the rows of the piece benches whole, and do they tell drift from none?"""

import numpy as np
import pytest

from station.bench import bench_piece_u95
from station.bench.piece import _Trial, _tried
from station.bench.piece_drifts import DRIFTS, NO_DRIFT, profile_piece
from station.bench.piece_stripes import calibrated_sensor
from station.progress import silent
from station.scenes import paper_sensor


@pytest.fixture(scope="module")
def calibrated():
    return calibrated_sensor(4, 1)


def test_focal_length_is_found_and_no_drift_is_not(calibrated):
    focal = next(one for one in DRIFTS if one.name == "focal length")
    rows = [
        _tried(_Trial(profile_piece(2.0), drift, "one picture", calibrated, 1, 1))
        for drift in (NO_DRIFT, focal)
    ]
    assert [row["found, %"] for row in rows] == [0.0, 100.0]
    assert list(rows[0]) == list(rows[1])
    assert rows[1]["found in 95 % from"]


def test_a_moved_sheet_shows_by_the_place_of_a_held_piece(calibrated):
    moved = next(one for one in DRIFTS if one.name == "sheet moved")
    row = _tried(_Trial(profile_piece(), moved, "held, since", calibrated, 1, 1))
    assert row["found, %"] == 100.0
    assert row["by"] == "place"


def test_no_drift_leaves_the_sensor_as_it_was_and_others_do_not():
    sensor = paper_sensor()
    for drift in DRIFTS:
        after = drift.drifted(sensor, 1.0)
        same = np.array_equal(after.plane.coefficients, sensor.plane.coefficients)
        same &= np.array_equal(after.camera.parameters, sensor.camera.parameters)
        assert same == (drift is NO_DRIFT)


def test_u95_table_has_a_row_for_every_dimension():
    table = bench_piece_u95(silent, pictures=4, runs=1)
    named = {row["dimension"] for row in table.rows}
    assert {"all dimensions", "profile", "size", "height 3-5", "corner 1-6"} <= named
    for row in table.rows:
        assert 0.0 <= float(row["within, %"]) <= 100.0
