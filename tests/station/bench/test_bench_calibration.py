"""Do the calibration's benches compare like with like?  Short runs; their figures are no claims."""

import time
import types

import numpy as np
import pytest

from calib import Method, calibrate, cramer_rao_bound
from station.bench import (
    BENCHES,
    bench_pose_sets,
    bench_solvers,
    bench_solving,
    bench_sweeps,
    calibration,
)
from station.bench.best_linear import BestLinear
from station.bench.peers import NOT_INSTALLED, peer
from station.bench.peers_calibration import peer_plane
from station.bench.simulation import HEIGHT_PX, SENSOR, TARGET, WIDTH_PX, Noise, Simulation
from station.bench.timing import CoreTime
from station.progress import silent

NOISE = Noise(0.5, 0.3)


@pytest.fixture(scope="module")
def simulation():
    return Simulation.drawn(6, 3)


def test_simulated_stripe_lies_on_board_and_sheet(simulation):
    for index, pose in enumerate(simulation.poses):
        off_mm = simulation.off_sheet_mm(index, pose, SENSOR.plane)
        # Undoing the lens ends at about 1e-9 px, a pixel being 0.2 mm.
        np.testing.assert_allclose(off_mm, 0.0, atol=1e-6)


def test_drawn_noise_is_what_moved_the_points(simulation, rng):
    drawn = simulation.noisy(rng, NOISE)
    for clean, view, dots, stripe in zip(
        simulation.clean, drawn.views, drawn.dots_px, drawn.stripe_px, strict=True
    ):
        np.testing.assert_allclose(view.points.centre_px - clean.points.centre_px, dots, atol=1e-9)
        across = ((view.stripe.centre_px - clean.stripe.centre_px) * clean.stripe.normal).sum(1)
        np.testing.assert_allclose(across, stripe, atol=1e-9)
        assert (view.stripe.sigma_px == NOISE.stripe_px).all()
    # 1,200 numbers tell a standard deviation to 2 %; five of those.
    assert drawn.dots_px.std() == pytest.approx(NOISE.dots_px, rel=0.1)


def test_covariance_of_the_best_linear_estimate_is_the_bound(simulation, rng):
    views = simulation.noisy(rng, NOISE).views
    bound = cramer_rao_bound(views, TARGET, SENSOR, simulation.poses)[9:, 9:]
    # Central differences of 1e-6 of the scale: good to some 1e-7.
    np.testing.assert_allclose(BestLinear.of(simulation, NOISE).covariance, bound, rtol=1e-5)


def test_best_linear_estimate_errs_as_its_covariance_says(simulation, rng):
    linear = BestLinear.of(simulation, NOISE)
    errors = np.array([linear.errors(simulation.noisy(rng, NOISE)) for _ in range(1000)])
    sigma = np.sqrt(np.diag(linear.covariance))
    # 1,000 draws tell a standard deviation to 2.2 %; four of those.
    np.testing.assert_allclose(np.sqrt(np.mean(errors**2, axis=0)), sigma, rtol=0.09)


def test_joint_and_best_linear_estimate_err_alike_at_little_noise(simulation, rng):
    noise = Noise(0.02, 0.02)
    linear, drawn = BestLinear.of(simulation, noise), simulation.noisy(rng, noise)
    found = calibrate(
        drawn.views, TARGET, width=WIDTH_PX, height=HEIGHT_PX, camera=SENSOR.camera
    ).sensor.plane.coefficients
    apart = found - SENSOR.plane.coefficients - linear.errors(drawn)
    # The robust weights, which the linear estimate has not, leave some hundredths of a sigma.
    np.testing.assert_allclose(apart / np.sqrt(np.diag(linear.covariance)), 0.0, atol=0.15)


def test_sweeps_have_a_row_a_level_and_joint_stays_near_the_bound():
    table = bench_sweeps(silent, poses=6, runs=4, levels_px=(0.0, 1.0))
    assert [(row["noise of"], row["level, px"]) for row in table.rows] == [
        ("dots", 0.0),
        ("dots", 1.0),
        ("stripe", 0.0),
        ("stripe", 1.0),
    ]
    for row in table.rows:
        # The draws are the same for both, so that four runs tell the ratio to about 3 %.
        assert row["joint over bound"] == pytest.approx(1.0, abs=0.12)
        assert {f"{method} {name}" for method in Method for name in "abcd"} <= set(row)


def test_pose_sets_are_told_by_their_quantiles():
    table = bench_pose_sets(silent, sets=3, poses=4, runs=1)
    assert [row["RMSE over bound"] for row in table.rows] == [*Method, "preplanar over joint"]
    for row in table.rows:
        spread = [row[name] for name in ("least", "quarter", "half", "three quarters", "most")]
        assert spread == sorted(spread)
        assert spread[0] > 0.0


def test_every_method_is_timed_with_the_camera_known_and_estimated(monkeypatch):
    monkeypatch.setattr(calibration, "_PICTURES_A_LIGHT", 1)
    table = bench_solving(silent, sizes=(4,), runs=1)
    assert len(table.rows) == 2 * len(Method) + 1
    assert all(row["s"] > 0.0 for row in table.rows)


def test_core_time_counts_work_and_not_waiting():
    assert CoreTime.of(lambda: time.sleep(0.02), runs=5).median_s < 0.01
    assert CoreTime.of(lambda: sum(range(2_000_000)), runs=1).median_s > 0.005


def test_a_missing_peer_is_a_row_that_says_so(monkeypatch):
    monkeypatch.setattr(calibration, "peer", lambda _module: None)
    ours, missing, bound = bench_solvers(silent, poses=4, runs=2).rows
    assert missing["solver"] == "vision-calibration"
    assert missing["a"] == missing["s"] == NOT_INSTALLED
    assert ours["a"] < 10.0 * bound["a"]


def test_a_peer_that_is_not_installed_is_none():
    assert peer("no_such_module_at_all") is None


def stand_in(normal, distance):
    """A solver with the peer's face, that answers a plane and keeps what it was given."""
    config = types.SimpleNamespace(optimize=types.SimpleNamespace(fix_poses=[0]))
    plane = types.SimpleNamespace(normal_xyz=normal, distance=distance)
    params = types.SimpleNamespace(plane=plane)
    kept = []

    def run(dataset, given):
        kept.append((dataset, given))
        return types.SimpleNamespace(estimate=types.SimpleNamespace(params=params))

    module = types.SimpleNamespace(
        LaserlineDeviceCalibrationConfig=lambda: config,
        LaserlineDataset=list,
        LaserlineView=lambda *parts: parts,
        Observation=lambda points, pixels: (points, pixels),
        run_laserline_device=run,
    )
    return module, kept


def test_a_peers_plane_is_turned_to_our_sign_and_none_of_its_poses_is_held(simulation):
    module, kept = stand_in((0.0, -0.6, 0.8), -5.0)
    plane = peer_plane(module, simulation.clean, TARGET)
    np.testing.assert_allclose(plane, [0.0, 0.6, -0.8, 5.0])
    ((dataset, config),) = kept
    assert len(dataset) == len(simulation.clean)
    assert config.optimize.fix_poses == []


@pytest.mark.slow
def test_the_peer_finds_the_same_plane(simulation):
    module = pytest.importorskip("vision_calibration")
    plane = peer_plane(module, simulation.clean, TARGET)
    np.testing.assert_allclose(plane, SENSOR.plane.coefficients, rtol=1e-2)


def test_every_bench_makes_tables():
    assert {"calibration", "stripe"} <= set(BENCHES)
    assert all(len(measures) >= 1 for measures in BENCHES.values())
