"""Gross errors: the joint method must stay within its own sigma, and say what it left out.

The errors are shifts of synthetic points; what glare does to a real dot is not shown here.
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import LED_TARGET, PAPER_CAMERA, PAPER_SENSOR, SIZE, noisy, setting

from calib import CameraRole, Cause, calibrate, calibrate_camera
from calib.solving.joint.belief import Belief, Place
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.problem import Problem
from calib.solving.prepared import Prepared

NOISE_PX = 0.05
# A true answer is within four of its own standard deviations but for one in 16,000; several
# correlated parameters and cases leave that one in a thousand.
WITHIN = 4.0


def shifted_dots(view, index, shift_px):
    centre = view.points.centre_px.copy()
    centre[index] += shift_px
    return replace(view, points=replace(view.points, centre_px=centre))


def shifted_stripe(view, index, shift_px):
    assert view.stripe is not None
    centre = view.stripe.centre_px.copy()
    centre[index] += shift_px
    return replace(view, stripe=replace(view.stripe, centre_px=centre))


def good(rng):
    place = setting(rng, 12, target=LED_TARGET)
    return [noisy(place.clean_view(index, 150), rng, NOISE_PX, NOISE_PX) for index in range(12)]


def gross_outliers(views, rng):
    """A fifth of all points of three views anywhere within 20 px or so."""
    for index in (0, 4, 8):
        view = views[index]
        dots = np.flatnonzero(rng.random(len(view.points)) < 0.2)
        stripe = np.flatnonzero(rng.random(len(view.stripe)) < 0.2)
        view = shifted_dots(view, dots, rng.normal(0.0, 20.0, (len(dots), 2)))
        views[index] = shifted_stripe(view, stripe, rng.normal(0.0, 20.0, (len(stripe), 2)))
    return views


def one_false_stripe(views, rng):
    views[3] = shifted_stripe(views[3], slice(None), [4.0, 30.0])
    return views


def third_of_stripes_false(views, rng):
    for index in (0, 3, 6, 9):
        shift = rng.choice([-1.0, 1.0]) * rng.uniform(2.0, 40.0)
        views[index] = shifted_stripe(views[index], slice(None), [0.0, shift])
    return views


def stripe_jumps(views, rng):
    """Two fifths of a stripe on a second line, in four views."""
    for index in (1, 2, 5, 7):
        views[index] = shifted_stripe(views[index], slice(0, 60), [0.0, 12.0])
    return views


def glare_blobs(views, rng):
    """Ten neighbouring dots of half the views drawn towards one place, by up to some pixels."""
    for index in range(0, 12, 2):
        seen = views[index].points.centre_px
        middle = seen[rng.integers(len(seen))]
        near = np.argsort(np.linalg.norm(seen - middle, axis=1))[:10]
        pull = 0.03 * (middle - seen[near]) + rng.normal(0.0, 0.2, 2)
        views[index] = shifted_dots(views[index], near, pull)
    return views


def everything(views, rng):
    return glare_blobs(one_false_stripe(gross_outliers(views, rng), rng), rng)


SPOILT = pytest.mark.parametrize(
    "spoil",
    [
        gross_outliers,
        one_false_stripe,
        third_of_stripes_false,
        stripe_jumps,
        glare_blobs,
        everything,
    ],
)


@SPOILT
def test_plane_stays_within_its_sigma(rng, spoil):
    for _ in range(3):
        found = calibrate(spoil(good(rng), rng), LED_TARGET, **SIZE, camera=PAPER_CAMERA)
        error = found.sensor.plane.coefficients - PAPER_SENSOR.plane.coefficients
        sigma = np.sqrt(np.diag(found.sensor.covariance)[9:])
        assert np.abs(error / sigma).max() < WITHIN
        # The scale follows the good points, not the bad.
        assert found.solve.sigma_scale_dots == pytest.approx(1.0, abs=0.15)
        assert found.solve.sigma_scale_stripe == pytest.approx(1.0, abs=0.15)


@SPOILT
def test_camera_and_plane_together_stay_within_their_sigma(rng, spoil):
    found = calibrate(spoil(good(rng), rng), LED_TARGET, **SIZE)
    truth = np.append(PAPER_CAMERA.parameters, PAPER_SENSOR.plane.coefficients)
    error = np.append(found.sensor.camera.parameters, found.sensor.plane.coefficients) - truth
    sigma = np.sqrt(np.diag(found.sensor.covariance))
    assert np.abs(error[sigma > 0.0] / sigma[sigma > 0.0]).max() < WITHIN


def test_gross_errors_are_named_and_good_points_are_kept(rng):
    views = good(rng)
    views[2] = shifted_dots(views[2], [5, 6, 7], [3.0, -3.0])
    views[2] = shifted_stripe(views[2], slice(10, 20), [0.0, 5.0])
    found = calibrate(views, LED_TARGET, **SIZE, camera=PAPER_CAMERA).views[2]
    assert [found.dots.cause[index] for index in (5, 6, 7)] == [Cause.OUTLIER] * 3
    assert not found.dots.used[[5, 6, 7]].any()
    assert set(found.stripe.cause[10:20]) == {Cause.OFF_LINE}
    # Of 53 and 140 good points, those beyond 3.9 sigma are doubted: none, mostly.
    assert np.count_nonzero(found.dots.used) >= 52
    assert np.count_nonzero(found.stripe.used) >= 138


def test_the_cause_seen_in_the_picture_is_not_overwritten(rng):
    views = good(rng)
    points = views[0].points
    cause = tuple(Cause.GLARE if index == 9 else Cause.NONE for index in range(len(points)))
    views[0] = shifted_dots(replace(views[0], points=replace(points, cause=cause)), [9], 8.0)
    found = calibrate(views, LED_TARGET, **SIZE, camera=PAPER_CAMERA).views[0]
    assert found.dots.cause[9] is Cause.GLARE
    assert not found.dots.used[9]


def test_a_false_stripe_is_left_out_as_a_whole_and_named(rng):
    found = calibrate(one_false_stripe(good(rng), rng), LED_TARGET, **SIZE, camera=PAPER_CAMERA)
    assert not found.views[3].stripe.used.any()
    assert set(found.views[3].stripe.cause) == {Cause.STRAY_LIGHT}
    assert any("view 3" in warning and "stripe" in warning for warning in found.warnings)
    assert all(view.stripe.used.any() for view in found.views if view.name != "view 3")


def test_a_view_of_another_target_is_left_out_and_named_not_fatal(rng):
    views = good(rng)
    points = views[5].points
    views[5] = replace(views[5], points=replace(points, row=rng.permutation(points.row)))
    # Rows permuted point by point: the same places twice.
    found = calibrate(views, LED_TARGET, **SIZE, camera=PAPER_CAMERA)
    assert found.views[5].cam_from_board is None
    assert found.views[5].dots is None
    assert found.views[5].left_out
    assert any(warning.startswith("view 5 left out") for warning in found.warnings)
    assert all(view.left_out == "" for view in found.views if view.name != "view 5")


def test_a_camera_is_solved_through_gross_errors(rng):
    found = calibrate_camera(everything(good(rng), rng), LED_TARGET, **SIZE)
    error = found.camera.parameters - PAPER_CAMERA.parameters
    sigma = np.sqrt(np.diag(found.camera.covariance))
    assert np.abs(error[sigma > 0.0] / sigma[sigma > 0.0]).max() < WITHIN


def test_neighbours_that_repeat_each_other_do_not_promise_too_much(rng):
    place = setting(rng, 12, target=LED_TARGET)
    clean = [place.clean_view(index, 300) for index in range(12)]
    kernel = np.exp(-0.125 * np.arange(-10, 11) ** 2)
    kernel /= np.linalg.norm(kernel)
    scaled = []
    for _ in range(20):
        views = []
        for view in clean:
            # Dots so good that the plane's doubt is the stripe's.
            dotted = noisy(view, rng, 0.002, 0.0)
            shift = 0.1 * np.convolve(rng.normal(size=320), kernel, "valid")
            stripe = replace(
                dotted.stripe,
                centre_px=dotted.stripe.centre_px + shift[:, None] * dotted.stripe.normal,
                sigma_px=np.full(300, 0.1),
            )
            views.append(replace(dotted, stripe=stripe))
        sensor = calibrate(views, LED_TARGET, **SIZE, camera=PAPER_CAMERA).sensor
        error = sensor.plane.coefficients - PAPER_SENSOR.plane.coefficients
        scaled.append(error / np.sqrt(np.diag(sensor.covariance)[9:]))
    # Counted one by one the points would give 2.7. 20 runs pin the ratio to 16 %, the length of
    # the runs is found to 10 %.
    assert np.sqrt(np.mean(np.square(scaled))) == pytest.approx(1.0, abs=0.35)


def test_true_stripes_are_let_in_where_noisy_dots_put_them_off_the_sheet(rng):
    # Dots of 2 px put the stripes of 0.1 px up to a hundred of their sigmas off.
    for _ in range(12):
        place = setting(rng, 10)
        views = place.views(rng, dots_px=2.0, stripe_px=0.1)
        found = calibrate(views, place.target, **SIZE, camera=PAPER_CAMERA)
        assert all(view.stripe.used.mean() > 0.8 for view in found.views)


def test_a_stripe_far_off_the_sheet_is_first_weighed_by_its_own_line(rng):
    views = one_false_stripe(good(rng), rng)
    views[3] = shifted_stripe(views[3], [0, 1], [0.0, 9.0])
    prepared = Prepared.of(views, LED_TARGET, PAPER_CAMERA, CameraRole.HELD)
    layout = Layout((), plane=True)
    everything_in = np.ones(len(views), dtype=bool)
    problem = Problem(prepared.observations, layout, None, everything_in, prepared.on_line)
    start = Estimate.start(PAPER_CAMERA, prepared.plane, list(prepared.poses))
    rays = PAPER_CAMERA.rays(prepared.observations.stripe.seen_px)[:, :2]
    belief = Belief.from_near(problem, Place.at(problem, start, rays))
    own = belief.stripe_weight[prepared.observations.stripe.view == 3]
    np.testing.assert_array_equal(own[:2], 0.0)
    assert own[2:].mean() > 0.98
