"""The benches of wheel readings, small: their rows are whole and they compare with the truth."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from measure import OF_A_PROFILE, Quantity, format_miniprof, parse_miniprof
from station.bench import (
    BENCHES,
    bench_intervals,
    bench_oblique,
    bench_profiles,
    bench_rolling,
    bench_train,
    bench_wheels,
    measure_intervals,
)
from station.bench.measure_profiles import _miniprof_of
from station.bench.wheel_stripes import PlacedWheel, StripeNoise
from station.bench.wheel_truths import true_values
from station.errors import InputUnusable
from station.progress import silent
from station.scenes import WheelTruth, paper_sensor, trackside_mounting

STILL = StripeNoise(sigma_px=1e-6, speckle_px=0.0)


def test_the_benches_of_readings_are_run_by_their_name():
    assert len(BENCHES["measure"]) >= 6


def test_rendered_wheels_are_read_as_asked():
    table = bench_wheels(silent, wears_mm=(3.0,), wheels_each=1)
    assert [row["quantity"] for row in table.rows[:5]] == [
        "tread_wear",
        "flange_height",
        "flange_thickness_10",
        "flange_thickness_12",
        "flange_gradient_qr",
    ]
    # One wheel of each reference: three of the demanded sigmas.
    for row in table.rows:
        assert row["read"] == "1 of 1"
        assert row["largest"] <= 3.0 * row["asked RMS"]


@pytest.mark.slow
def test_every_oblique_cut_of_the_nominal_radius_is_read_as_asked():
    table = bench_oblique(silent, wheels_each=1)
    assert all(row["holds"] for row in table.rows if "radius 420" in row["what"])


@pytest.mark.parametrize(("axle_x_mm", "lifted_mm"), [(0.0, 0.0), (70.0, 1.5), (-70.0, -1.5)])
def test_drawn_stripes_lie_on_the_wheel_they_are_of(axle_x_mm, lifted_mm, rng):
    wheel, sensor, rig = WheelTruth(tread_wear_mm=3.0), paper_sensor(), trackside_mounting("left")
    placed = PlacedWheel(wheel, sensor, rig, axle_x_mm, 5.0, lifted_mm)
    stripe = placed.stripe(rng, STILL, pull=0.0)
    x, y, z = rig.apply(sensor.locate(stripe.centre_px)).T
    radius = np.hypot(x - axle_x_mm, z - wheel.radius_mm - lifted_mm)
    outline = cKDTree(wheel.profile.points_mm)
    off, _ = outline.query(np.column_stack([y - 5.0, radius - wheel.radius_mm]))
    assert len(stripe) > 600
    # Half the spacing of the outline's points is 0.025 mm.
    assert off.max() < 0.03


def test_what_neighbours_share_is_as_large_as_is_said(rng):
    placed = PlacedWheel(WheelTruth(), paper_sensor(), trackside_mounting("left"))
    clean = placed.stripe(rng, STILL)
    moved = [
        np.sum((placed.stripe(rng, StripeNoise()).centre_px - clean.centre_px) * clean.normal, 1)
        for _ in range(20)
    ]
    # 20 stripes of 800 points, of which 6 neighbours count as one: 1.4 %; four of those.
    assert np.std(moved) == pytest.approx(np.hypot(0.045, 0.004), rel=0.06)


def test_pictures_of_a_rolling_wheel_are_better_together():
    rows = bench_rolling(silent, wheels=6, middles_mm=(0.0,), yaws_deg=(0.0,)).rows
    told = {row["pictures"]: row["flange_height u95, mm"] for row in rows}
    together = told.pop("all together")
    # Of five pictures the noise of one falls to 0.45; the outer ones add their doubt of the axle.
    assert together < 0.7 * min(told.values())
    assert abs(rows[-1]["flange_height mean, mm"]) < 0.015


def test_intervals_of_a_few_drawn_wheels_hold_the_truth(monkeypatch):
    monkeypatch.setattr(measure_intervals, "calibrated_covariance", lambda _: np.zeros((13, 13)))
    rows = bench_intervals(silent, draws={1: 40}).rows
    assert [row["quantity"] for row in rows] == [quantity.value for quantity in OF_A_PROFILE]
    # 40 wheels of which 95 % are inside: 3.4 %; three and a half of those.
    assert min(row["inside u95"] for row in rows) >= 0.83


@pytest.mark.slow
def test_intervals_hold_the_truth_93_to_97_times_of_a_hundred_drawn_wheels():
    rows = bench_intervals(silent, draws={1: 800}).rows
    assert all(row["holds"] for row in rows)


def test_made_up_profiles_are_read_as_their_headers_say():
    table = bench_profiles(silent)
    assert len(table.rows) == 8
    assert all(row["holds"] is True for row in table.rows)


@pytest.mark.parametrize(
    ("wrong_by", "holds"), [(0.0, True), (0.2, False), (5.0, "states another wheel")]
)
def test_a_header_is_compared_with_its_points(wrong_by, holds, tmp_path, rng):
    parsed = parse_miniprof(_miniprof_of(WheelTruth(tread_wear_mm=2.0), rng))
    sh = float(parsed.header["Sh"]) + wrong_by
    text = format_miniprof(parsed.profile, {**parsed.header, "Sh": f"{sh:.4f}"})
    (tmp_path / "wheel.whl").write_text(text)
    (row,) = bench_profiles(silent, folder=tmp_path).rows
    assert row["holds"] == holds


def test_files_that_are_no_profiles_are_told(tmp_path):
    with pytest.raises(InputUnusable, match="give MiniProf files"):
        bench_profiles(silent, folder=tmp_path)
    (tmp_path / "notes.txt").write_text("no wheel")
    (row,) = bench_profiles(silent, folder=tmp_path).rows
    assert "unreadable" in row["holds"]


def test_a_train_is_measured_whole():
    frame, train = bench_train(silent, wheels=2, runs=1).rows
    assert frame["figure"] > 1.0
    assert train["spread"] == "2 of 2 wheels read"


def test_true_wear_and_hollow_are_those_of_the_outline():
    new, worn = (true_values(WheelTruth(tread_wear_mm=wear)) for wear in (0.0, 4.0))
    assert new[Quantity.TREAD_WEAR_MAX] == pytest.approx(0.0, abs=1e-3)
    assert new[Quantity.HOLLOW_DEPTH] == 0.0
    assert worn[Quantity.TREAD_WEAR_MAX] == pytest.approx(worn[Quantity.TREAD_WEAR], abs=0.1)
    assert 1.0 < worn[Quantity.HOLLOW_DEPTH] < 4.0
