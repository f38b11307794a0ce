"""The bench of the rig's solve runs, and what it measures is what it foretells."""

import pytest

from station.bench import BENCHES, bench_rig_calibration


def test_rows_hold_time_miss_and_what_was_foretold():
    table = bench_rig_calibration(lambda part, what: None, sizes=(5,), runs=6)
    (row,) = table.rows
    assert row["showings"] == 5
    # Six runs of one or two directions that count: a factor of two is five sigmas.
    assert row["ratio"] == pytest.approx(1.0, abs=0.8)
    assert 0.0 < row["predicted, mm"] < 0.5
    # A tenth of what is allowed, and a busy machine's processor clock.
    assert 0.0 < row["s"] < 1.0
    assert bench_rig_calibration in BENCHES["rig-calibration"]
