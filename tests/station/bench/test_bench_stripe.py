"""Do the stripe's benches compare with the truth?  Short runs; their figures are no claims."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from station.bench import bench_stripe, bench_stripe_sigma, peers_stripe
from station.bench.peers import NOT_INSTALLED
from station.bench.peers_stripe import extractors, ridge_points
from station.bench.stripe import stripe_bound_px
from station.bench.stripe_frames import WIDTH_PX, Glare, StripeFrame, off_stripe_px
from station.progress import silent


def test_brightest_place_of_each_column_is_the_true_centre():
    frame = StripeFrame(width_px=2.0)
    light = frame.light() - 12.0
    rows = np.arange(len(light))[:, None]
    centroid = (light * rows).sum(axis=0) / light.sum(axis=0)
    points = np.column_stack([np.arange(WIDTH_PX, dtype=float), centroid])
    # The tails reach 250 sigma: nothing is cut off but rounding.
    np.testing.assert_allclose(off_stripe_px(points), 0.0, atol=1e-6)


def test_distance_from_the_stripe_is_measured_across_it():
    points = np.array([[2000.0, 1.0], [2000.0, 3.0]])
    apart = np.diff(off_stripe_px(points))
    assert apart == pytest.approx(2.0 / np.hypot(1.0, 0.06 + 4e-5 * (2000.0 - 1023.5)))


def test_glare_clips_and_the_clean_frame_does_not(rng):
    assert StripeFrame().taken(rng).max() < 255
    assert (StripeFrame(glare=Glare.GLARE).taken(rng) == 255).sum() > 1000


def test_bound_is_equation_9_where_the_kernel_is_as_wide_as_the_seen_stripe():
    seen = 2.0
    width = np.sqrt(seen**2 - 1.0 / 12.0)
    bound = stripe_bound_px(width, 100.0 * seen / width, 3.0, np.array([seen]))
    equation_9 = 3.0 / 100.0 * np.sqrt((2.0 * seen**2) ** 3 / (8.0 * np.pi * seen**6))
    np.testing.assert_allclose(bound, equation_9)


def test_ridge_points_lie_on_a_slanted_ridge():
    v, u = np.mgrid[:60, :80].astype(float)
    light = gaussian_filter(150.0 * np.exp(-0.5 * ((v - 30.3 - 0.2 * (u - 40)) / 2.0) ** 2), 2.0)
    gradient = np.stack(np.gradient(light)[::-1])
    second_v, second_u = np.gradient(gradient[1]), np.gradient(gradient[0])
    found = ridge_points(gradient, np.stack([second_u[1], second_u[0], second_v[0]]))
    middle = found[(found[:, 0] > 15) & (found[:, 0] < 65)]
    # 49 columns; where the ridge passes between two pixels neither may claim it.
    assert len(middle) > 35
    # Differences of one pixel on a bell of 2.8: some hundredths of a pixel at most.
    np.testing.assert_allclose(middle[:, 1], 30.3 + 0.2 * (middle[:, 0] - 40), atol=0.05)


def test_ours_is_measured_in_both_frames_and_missing_peers_say_so(monkeypatch):
    monkeypatch.setattr(peers_stripe, "peer", lambda _module: None)
    table = bench_stripe(silent, runs=1)
    assert [row["frame"] for row in table.rows] == ["clean"] * 3 + ["glare"] * 3
    clean, glare = table.rows[0], table.rows[3]
    # Expected 0.010 px from 1.5 counts of read and as much of shot noise.
    assert 0.005 < clean["RMS, px"] < 0.02
    assert clean["false points"] == 0
    assert glare["RMS weighted, px"] < 0.02
    assert {row["RMS, px"] for row in table.rows if row not in (clean, glare)} == {NOT_INSTALLED}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # the peers warn of their own affairs
def test_installed_peers_find_the_clean_stripe(rng):
    picture = StripeFrame().taken(rng)
    for extract in extractors().values():
        if extract is not None:
            off = off_stripe_px(extract(picture).centre_px)
            assert np.median(np.abs(off)) < 0.05


def test_sigma_is_near_scatter_and_bound():
    table = bench_stripe_sigma(silent, pictures=1)
    for row in table.rows:
        # One frame holds about 2048 / (2 sqrt(pi) 3 px) = 190 independent points: 5 %, and the
        # noise told from the picture 5 %.
        assert row["told over scatter"] == pytest.approx(1.0, abs=0.2)
        assert row["told over bound"] == pytest.approx(1.0, abs=0.1)
