"""How near the joint method comes to the Cramér-Rao bound, and whether its sigmas are true.

All noise is normal and independent here; pictures are another matter (`test_joint_robustness`
has gross errors, the scenes' tests have pictures).
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import (
    PAPER_CAMERA,
    PAPER_SENSOR,
    PAPER_TARGET,
    SIZE,
    Setting,
    noisy,
    setting,
)

from calib import CameraModel, CameraRole, Method, Target, calibrate, cramer_rao_bound
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.observations import Observations

POSES = 10
# The paper's two sweeps: noise of dots beside stripe at 0.5 px, and the other way round.
SHORT = [(0.0, 0.5), (0.5, 0.5), (5.0, 0.5), (0.5, 0.0), (0.5, 5.0)]
LEVELS = np.arange(0.0, 5.1, 0.5)
LONG = [(level, 0.5) for level in LEVELS] + [(0.5, level) for level in LEVELS]
TRUTH = PAPER_SENSOR.plane.coefficients


def best_linear_errors(place: Setting, views) -> np.ndarray:
    """Return the errors of (a, b, c, d) of the estimate that reaches the bound to first order.

    It knows the truth, takes one step from it, and has the bound for its covariance. A method's
    error relative to it tells a few per cent in 40 runs, where the bound itself would need 2,000.
    """
    seen, layout = Observations.of(views, place.target), Layout((), plane=True)
    truth = Estimate.start(place.sensor.camera, place.sensor.plane, list(place.poses))
    dots = linearise_dots(seen, truth, layout)
    stripe = linearise_stripe(seen.stripe, truth, layout)
    step, _, _ = (
        NormalEquations.of(dots, np.ones(len(seen.dots)), seen.dots.view, seen.count)
        + NormalEquations.of(stripe, np.ones(len(seen.stripe)), seen.stripe.view, seen.count)
    ).step(damping=0.0)
    return (layout.sensor_from_global(truth) @ step)[9:]


def rms(errors) -> np.ndarray:
    return np.sqrt(np.mean(np.square(errors), axis=0))


def sweep(rng, level, runs, methods=(Method.JOINT,)):
    """Return RMS errors of (a, b, c, d) of the best linear estimate, then of each method."""
    place = setting(rng, POSES)
    clean = [place.clean_view(index, PAPER_TARGET.cols) for index in range(POSES)]
    errors = [[] for _ in range(1 + len(methods))]
    for _ in range(runs):
        views = [noisy(view, rng, *level) for view in clean]
        errors[0].append(best_linear_errors(place, views))
        for own, method in zip(errors[1:], methods, strict=True):
            found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)
            own.append(found.sensor.plane.coefficients - TRUTH)
    return [rms(own) for own in errors]


def assert_reaches_the_bound(rng, level, runs):
    linear, joint = sweep(rng, level, runs)
    # All four together: a, b, c and d move as one. 5 % is what is asked; at 5 px of dot noise
    # the second order, which no linear bound knows, is 1-3 % of it.
    assert np.sqrt(np.mean((joint / linear) ** 2)) < 1.05


@pytest.mark.parametrize("level", SHORT, ids=str)
def test_rms_error_is_within_five_per_cent_of_the_bound(rng, level):
    assert_reaches_the_bound(rng, level, runs=20)


@pytest.mark.slow
@pytest.mark.parametrize("level", LONG, ids=str)
def test_rms_error_is_within_five_per_cent_of_the_bound_at_every_level(rng, level):
    assert_reaches_the_bound(rng, level, runs=100)


def test_best_linear_estimate_scatters_as_the_bound_says(rng):
    place = setting(rng, POSES)
    clean = [place.clean_view(index, PAPER_TARGET.cols) for index in range(POSES)]
    views = [noisy(view, rng, 0.5, 0.5) for view in clean]
    bound = cramer_rao_bound(views, PAPER_TARGET, PAPER_SENSOR, place.poses)
    errors = [
        best_linear_errors(place, [noisy(view, rng, 0.5, 0.5) for view in clean])
        for _ in range(400)
    ]
    # 400 draws pin a standard deviation to 3.5 %; four of those.
    np.testing.assert_allclose(rms(errors), np.sqrt(np.diag(bound)[9:]), rtol=0.14)


def test_at_large_dot_noise_the_baseline_errs_many_times_more(rng):
    _, joint, baseline = sweep(rng, (5.0, 0.5), 15, (Method.JOINT, Method.PREPLANAR))
    # Ten times is typical and depends on the poses; 15 runs pin a ratio to 26 %.
    assert np.sqrt(np.mean((baseline / joint) ** 2)) > 6.0


def scaled_errors(rng, runs, *, camera, target=PAPER_TARGET, poses=POSES, understated=1.0):
    """Return errors of the sensor over their predicted sigma, of the parameters with one."""
    place = setting(rng, poses, target=target)
    clean = [place.clean_view(index, 60) for index in range(poses)]
    truth = np.append(PAPER_CAMERA.parameters, TRUTH)
    scaled = []
    for _ in range(runs):
        views = [understate(noisy(view, rng, 0.1, 0.1), understated) for view in clean]
        sensor = calibrate(views, target, **SIZE, camera=camera).sensor
        found = np.append(sensor.camera.parameters, sensor.plane.coefficients)
        sigma = np.sqrt(np.diag(sensor.covariance))
        known = sigma > 0.0
        # k3 and the tangential terms join by chance in a few runs; their truth is zero.
        known[6:9] = False
        scaled.append(((found - truth) / np.where(known, sigma, 1.0))[known])
    return np.array(scaled)


def understate(view, factor):
    return replace(
        view,
        points=replace(view.points, sigma_px=view.points.sigma_px / factor),
        stripe=replace(view.stripe, sigma_px=view.stripe.sigma_px / factor),
    )


CASES = pytest.mark.parametrize(
    ("camera", "target", "understated"),
    [
        (PAPER_CAMERA, PAPER_TARGET, 1.0),
        (PAPER_CAMERA, Target.parse("dots:10x10:10:d=6"), 3.0),
        (None, PAPER_TARGET, 1.0),
    ],
    ids=["camera held", "discs, sigmas understated three times", "camera estimated"],
)


@CASES
def test_predicted_sigma_matches_the_scatter(rng, camera, target, understated):
    scaled = scaled_errors(rng, 30, camera=camera, target=target, understated=understated)
    # One standard deviation of 30 runs is known to 13 %. Those of one plane or camera go together
    # but for two or three directions, so their mean is known to about 8 %; three of those.
    assert rms(scaled).mean() == pytest.approx(1.0, abs=0.24)


@pytest.mark.slow
@CASES
def test_predicted_sigma_is_true_within_ten_per_cent_and_intervals_cover(
    rng, camera, target, understated
):
    scaled = np.concatenate([
        scaled_errors(rng, 60, camera=camera, target=target, understated=understated)
        for _ in range(10)
    ])
    assert rms(scaled).mean() == pytest.approx(1.0, abs=0.10)
    assert np.mean(np.abs(scaled) < 1.96) == pytest.approx(0.95, abs=0.02)


def test_a_camera_with_a_covariance_is_a_prior_and_ends_better_known(rng):
    place = setting(rng, POSES)
    views = place.views(rng, dots_px=0.1, stripe_px=0.1)
    sigma = np.array([4.0, 4.0, 3.0, 3.0, 0.01, 0.02, 0.0, 0.0, 0.0])
    guess = CameraModel.from_parameters(
        PAPER_CAMERA.parameters + rng.normal(size=9) * sigma, **SIZE, covariance=np.diag(sigma**2)
    )
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=guess)
    assert found.solve.camera is CameraRole.PRIOR
    after = np.sqrt(np.diag(found.sensor.camera.covariance))
    assert (after[:6] < sigma[:6]).all()
    assert (after[6:] == 0.0).all()
    scaled = (found.sensor.camera.parameters - PAPER_CAMERA.parameters)[:6] / after[:6]
    assert np.abs(scaled).max() < 4.5


def test_a_strong_prior_is_kept(rng):
    place = setting(rng, 4)
    views = place.views(rng, dots_px=1.0, stripe_px=1.0)
    covariance = np.zeros((9, 9))
    covariance[0, 0] = 1e-6
    guess = CameraModel.from_parameters(PAPER_CAMERA.parameters, **SIZE, covariance=covariance)
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=guess)
    assert found.sensor.camera.fx == pytest.approx(PAPER_CAMERA.fx, abs=0.01)


def test_turning_the_numbering_of_the_target_changes_no_plane(rng):
    place = setting(rng, 5)
    views = place.views(rng, dots_px=0.2, stripe_px=0.2)
    turned = [
        replace(
            view,
            points=replace(view.points, row=9 - view.points.row, col=9 - view.points.col),
        )
        for view in views
    ]
    one = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA).sensor
    other = calibrate(turned, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA).sensor
    # The solves end within a thousandth of a standard deviation each.
    sigma = np.sqrt(np.diag(one.covariance)[9:])
    np.testing.assert_allclose(
        (other.plane.coefficients - one.plane.coefficients) / sigma, 0.0, atol=0.02
    )


def test_corrected_points_of_noise_free_views_are_the_points_themselves(rng):
    place = setting(rng, 4)
    found = calibrate(
        place.views(rng, dots_px=0.0, stripe_px=0.0), PAPER_TARGET, **SIZE, camera=PAPER_CAMERA
    )
    for index, view in enumerate(found.views):
        clean = place.clean_view(index, 10)
        np.testing.assert_allclose(view.dots.corrected_px, clean.points.centre_px, atol=1e-4)
        np.testing.assert_allclose(view.stripe.corrected_px, clean.stripe.centre_px, atol=1e-4)
    np.testing.assert_allclose(found.sensor.plane.coefficients, TRUTH, rtol=1e-6)
    assert found.rms_dots_px < 1e-4
    assert found.rms_stripe_px < 1e-4


def test_scatter_is_not_understated_where_points_are_few(rng):
    # Nine dots and eight stripe points a view: of 26 numbers the pose takes six.
    target = Target.parse("dots:3x3:40")
    place = setting(rng, 6, target=target)
    clean = [place.clean_view(index, 8) for index in range(6)]
    scales = []
    for _ in range(40):
        views = [noisy(view, rng, 0.2, 0.2) for view in clean]
        report = calibrate(views, target, **SIZE, camera=PAPER_CAMERA).solve
        scales.append((report.sigma_scale_dots, report.sigma_scale_stripe))
    # Without the freedoms spent the dots' would be 0.83 at most. One scale of 75 or 40 freedoms
    # is known to 8 and 11 %; forty to 1.8 %, and the root of a mean square is 1 % low.
    np.testing.assert_allclose(np.mean(scales, axis=0), 1.0, atol=0.06)
