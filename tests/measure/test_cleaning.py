"""Which points count as the wheel, and how their scatter is told from them."""

import numpy as np
import pytest
import wheel_stripes as ws
from scipy.signal import savgol_filter

from calib import Cause
from measure import reference_profile
from measure.keeping.cleaning import keep_wheel
from measure.keeping.noise import _running_parabola, noise_of
from measure.placing.flange import Voters, find_flanges
from measure.placing.pieces import pieces, sizes
from measure.placing.registration import best_shift, refine_shift, see_back_face
from measure.placing.template import template_of

TEMPLATE = template_of(reference_profile("S1002"))
_PX_MM = 0.3


def laid(extra=(), sigma_mm=0.01, rng=None):
    """Points of an S1002 laid on itself, as if each 0.3 mm were a pixel, and strays (y, z)."""
    points = reference_profile("S1002").points(_PX_MM, back_face_mm=10.0)
    points = np.concatenate([points, np.reshape(extra, (-1, 2))])
    if rng is not None:
        points = points + rng.normal(0.0, sigma_mm, points.shape)
    normal = np.gradient(points, axis=0)[:, ::-1] * [-1.0, 1.0]
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    stripe = ws.make_stripe(points / _PX_MM + 400.0, normal)
    return points, np.full(len(points), sigma_mm), stripe


def test_a_clean_profile_is_kept_whole_and_in_order(rng):
    points, sigma, stripe = laid(rng=rng)
    kept = keep_wheel(points, sigma, stripe, TEMPLATE)
    # Four sigmas cut off 6 of 100,000 points.
    assert len(kept.index) >= len(points) - 1
    assert (np.diff(kept.along_mm) >= 0.0).all()


@pytest.mark.parametrize(
    ("place", "cause"),
    [
        ([[0.0, 4.0]], Cause.STRAY_LIGHT),  # out in the air
        ([[0.0, -20.0]], Cause.STRAY_LIGHT),  # deep in the wheel
        ([[-72.9, -2.0]], Cause.STRAY_LIGHT),  # behind the back face
        ([[20.0, -2.0]], Cause.STRAY_LIGHT),  # where wear may be, but by itself
    ],
)
def test_points_that_cannot_be_the_wheel_are_left_out(place, cause, rng):
    points, sigma, stripe = laid(place, rng=rng)
    kept = keep_wheel(points, sigma, stripe, TEMPLATE)
    assert len(points) - 1 not in kept.index
    assert kept.left_out[cause] >= 1


def test_of_two_layers_the_larger_one_is_the_wheel(rng):
    u = np.arange(-10.0, 30.0, _PX_MM)
    below = np.column_stack([u, np.full(len(u), -3.0)])
    points, sigma, stripe = laid(below, rng=rng)
    kept = keep_wheel(points, sigma, stripe, TEMPLATE)
    assert kept.left_out[Cause.GLARE] >= 0.95 * len(below)
    assert kept.index.max() < len(points) - 0.05 * len(below)


def test_a_point_that_sticks_out_is_left_out(rng):
    points, sigma, stripe = laid(rng=rng)
    points = points.copy()
    points[300, 1] += 0.2
    kept = keep_wheel(points, sigma, stripe, TEMPLATE)
    assert 300 not in kept.index
    assert kept.left_out[Cause.OUTLIER] >= 1


def test_a_second_stripe_across_is_another_piece():
    u = np.arange(100.0)
    level = np.column_stack([u, np.full(100, 50.0)])
    upright = np.column_stack([np.full(100, 50.0), u])
    normals = np.repeat([[0.0, 1.0], [1.0, 0.0]], 100, axis=0)
    piece = pieces(np.concatenate([level, upright]), normals)
    assert len(np.unique(piece)) == 2
    assert (sizes(piece) == 100).all()


def noise_seen(height, sigma_mm=0.002, width_mm=0.4):
    along = 0.3 * np.arange(len(height))
    full = np.full(len(height), 1.0)
    return noise_of(along, height, sigma_mm * full, width_mm * full, np.ones(len(height), bool))


def test_white_noise_as_predicted_is_left_as_it_is(rng):
    noise = noise_seen(rng.normal(0.0, 0.01, 600), sigma_mm=0.01)
    # 600 points tell a standard deviation to 5 % by their median; 1.5 times is no chance.
    assert noise.counting_mm[0] == pytest.approx(0.01, rel=0.15)


def test_speckle_that_neighbours_share_is_seen_for_what_it_is(rng):
    kernel = np.exp(-0.5 * (np.arange(-10, 11) / 2.5) ** 2)
    kernel /= np.linalg.norm(kernel)
    height = np.convolve(rng.normal(0.0, 0.016, 3000), kernel, mode="valid")
    noise = noise_seen(height)
    # The sum of the correlations of a kernel of 2.5 points is 2 sqrt(pi) 2.5 = 8.9; what is
    # longer than the running parabola's 61 points is lost to it.
    assert noise.sigma_mm[0] == pytest.approx(0.016, rel=0.15)
    assert noise.run_points == pytest.approx(8.9, rel=0.25)


def test_a_short_run_of_shared_errors_is_told_to_a_tenth(rng):
    told = []
    for _ in range(8):
        kernel = np.exp(-0.5 * (np.arange(-8, 9) / 1.65) ** 2)
        kernel /= np.linalg.norm(kernel)
        height = np.convolve(rng.normal(0.0, 0.016, 466), kernel, mode="valid")
        told.append(noise_seen(height).run_points)
    # A kernel of 1.65 points, as speckle has on a rendered wheel: 2 sqrt(pi) 1.65 = 5.8.
    assert np.mean(told) == pytest.approx(5.8, rel=0.1)
    assert np.max(told) < 8.5


@pytest.mark.parametrize("points", [21, 45])
def test_running_parabola_is_the_filter_of_savitzky_and_golay(points, rng):
    values = rng.normal(size=200)
    expected = savgol_filter(values, points, 2)
    np.testing.assert_allclose(_running_parabola(values, points), expected, atol=1e-12)


def voters(points, flip=1.0):
    tangent = np.gradient(points, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    return Voters(points, tangent, np.tile([0.2, flip], (len(points), 1)))


def test_a_flange_is_found_where_it_is():
    points = reference_profile("S1002").points(0.3) + [12.0, 433.0]
    (found,) = find_flanges(voters(points), TEMPLATE)
    # A cell of the vote is 2 mm wide.
    np.testing.assert_allclose(found.shift_mm, [12.0, 433.0], atol=1.0)


def test_a_flange_seen_from_within_the_wheel_is_none():
    points = reference_profile("S1002").points(0.3)
    assert find_flanges(voters(points, flip=-5.0), TEMPLATE) == ()


def test_two_flanges_are_both_told():
    points = reference_profile("S1002").points(0.3)
    both = Voters(
        *(
            np.concatenate([getattr(voters(points), name)] * 2) + shift
            for name, shift in (
                ("points_mm", np.repeat([[0.0, 0.0], [160.0, 0.0]], len(points), axis=0)),
                ("tangent", 0.0),
                ("to_camera", 0.0),
            )
        )
    )
    assert len(find_flanges(both, TEMPLATE)) == 2


def test_a_rough_shift_is_refined_on_back_and_tip(rng):
    points, _, stripe = laid(rng=rng)
    worn = points - np.column_stack([np.zeros(len(points)), 4.0 * (points[:, 0] > -20.0)])
    shift = refine_shift(worn + [3.0, 400.0], np.array([4.2, 398.9]), TEMPLATE)
    # 160 points of 0.01 mm: a micrometre or two across, and along through the tip's curvature.
    np.testing.assert_allclose(shift, [3.0, 400.0], atol=0.01)
    found = best_shift(worn + [3.0, 400.0], stripe, [np.array([4.2, 397.0])], TEMPLATE)
    np.testing.assert_allclose(found, [3.0, 400.0], atol=0.01)


def test_back_face_is_the_mean_of_its_points_without_the_dirt_on_it(rng):
    points, sigma, _ = laid(rng=rng)
    points = points.copy()
    points[5:9, 0] -= 0.6
    back = see_back_face(points, sigma, np.zeros(2), TEMPLATE)
    # Some 30 points of 0.01 mm.
    assert back.a_mm == pytest.approx(-70.0, abs=0.006)
    assert back.gradient.sum() == pytest.approx(1.0)


def test_a_scrap_of_back_face_is_not_trusted(rng):
    points, sigma, _ = laid(rng=rng)
    assert see_back_face(points[27:], sigma[27:], np.zeros(2), TEMPLATE) is None
