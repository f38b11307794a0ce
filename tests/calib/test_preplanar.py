"""The baseline as the paper describes it: right on exact points, noisy on noisy ones."""

from dataclasses import replace

import numpy as np
from synthetic_views import (
    PAPER_CAMERA,
    PAPER_SENSOR,
    PAPER_TARGET,
    SIZE,
    Setting,
    noisy,
    setting,
)

from calib import (
    CameraModel,
    CameraRole,
    LightPlane,
    Method,
    RigidTransform,
    Termination,
    calibrate,
)
from calib.lines import fit_line, fit_plane
from calib.solving.crossings import crossed_lines, crossings_mm
from calib.solving.prepared import Prepared
from calib.solving.preplanar import consensus, crossed_by_stripes, points_in_cam

PREPLANAR = {**SIZE, "camera": PAPER_CAMERA, "method": Method.PREPLANAR}
TRUTH = PAPER_SENSOR.plane.coefficients


def test_exact_points_give_the_exact_plane(rng):
    found = calibrate(setting(rng, 5).views(rng, dots_px=0, stripe_px=0), PAPER_TARGET, **PREPLANAR)
    np.testing.assert_allclose(found.sensor.plane.coefficients, TRUTH, atol=1e-6)
    assert found.solve.termination is Termination.CLOSED_FORM


def crossings(view):
    rays = PAPER_CAMERA.rays(view.points.centre_px)[:, :2]
    stripe = fit_line(PAPER_CAMERA.rays(view.stripe.centre_px)[:, :2])
    lines = crossed_lines(view.points, PAPER_TARGET, rays, stripe)
    return crossings_mm(lines, PAPER_TARGET, rays, stripe)


def test_crossings_lie_on_the_columns_and_on_the_sheet(rng):
    place = setting(rng, 3)
    for index, pose in enumerate(place.poses):
        found = crossings(place.clean_view(index, 10))
        assert len(found) >= 3
        np.testing.assert_allclose(found[:, 0], 10.0 * np.round(found[:, 0] / 10.0), atol=1e-9)
        in_cam = pose.apply(np.column_stack([found, np.zeros(len(found))]))
        np.testing.assert_allclose(PAPER_SENSOR.plane.distance_mm(in_cam), 0.0, atol=1e-6)


def test_a_stripe_along_the_columns_is_crossed_with_the_rows(rng):
    quarter = RigidTransform.from_rotation_vector([0.0, 0.0, np.pi / 2], [90.0, 0.0, 0.0])
    turned = tuple(pose @ quarter for pose in setting(rng, 3).poses)
    place = Setting(PAPER_SENSOR, PAPER_TARGET, turned)
    for index in range(3):
        found = crossings(place.clean_view(index, 10))
        np.testing.assert_allclose(found[:, 1], 10.0 * np.round(found[:, 1] / 10.0), atol=1e-9)


def test_one_false_stripe_is_left_out_by_the_random_samples(rng):
    views = setting(rng, 8).views(rng, dots_px=0.05, stripe_px=0.05)
    stripe = views[2].stripe
    lower = replace(stripe, centre_px=stripe.centre_px + [0.0, 40.0])
    views[2] = replace(views[2], stripe=lower)
    found = calibrate(views, PAPER_TARGET, **PREPLANAR)
    assert not found.views[2].stripe.used.any()
    np.testing.assert_allclose(found.sensor.plane.coefficients[:3], TRUTH[:3], atol=5e-3)


def test_points_are_not_corrected(rng):
    views = setting(rng, 4).views(rng, dots_px=0.5, stripe_px=0.5)
    for view, solved in zip(views, calibrate(views, PAPER_TARGET, **PREPLANAR).views, strict=True):
        np.testing.assert_array_equal(solved.dots.corrected_px, view.points.centre_px)
        np.testing.assert_array_equal(solved.stripe.corrected_px, view.stripe.centre_px)


def test_jackknife_covariance_is_of_the_size_of_the_scatter(rng):
    place = setting(rng, 12)
    clean = [place.clean_view(index, 10) for index in range(12)]
    errors, sigmas = [], []
    for _ in range(40):
        sensor = calibrate(
            [noisy(view, rng, 0.5, 0.5) for view in clean], PAPER_TARGET, **PREPLANAR
        ).sensor
        errors.append(sensor.plane.coefficients - TRUTH)
        sigmas.append(np.sqrt(np.diag(sensor.covariance)[9:]))
    ratio = np.std(errors, axis=0) / np.sqrt(np.mean(np.square(sigmas), axis=0))
    # 12 views of unequal worth leave a jackknife uncertain by a third or more.
    assert ((ratio > 0.4) & (ratio < 2.0)).all()


def test_doubt_of_the_camera_is_carried_to_the_plane(rng):
    views = setting(rng, 8).views(rng, dots_px=0.05, stripe_px=0.05)
    step = np.array([20.0, 20.0, 0, 0, 0, 0, 0, 0, 0])
    doubtful = CameraModel.from_parameters(
        PAPER_CAMERA.parameters, **SIZE, covariance=np.outer(step, step)
    )
    longer = CameraModel.from_parameters(PAPER_CAMERA.parameters + step, **SIZE)
    exact, found = (
        calibrate(views, PAPER_TARGET, **{**PREPLANAR, "camera": camera}).sensor
        for camera in (PAPER_CAMERA, doubtful)
    )
    # The same points before and after: which of them agree is not the camera's doubt.
    prepared = Prepared.of(views, PAPER_TARGET, PAPER_CAMERA, CameraRole.HELD)
    selection = crossed_by_stripes(prepared)
    kept = consensus(points_in_cam(prepared, PAPER_CAMERA, selection))
    planes = [
        LightPlane.from_coefficients(
            fit_plane(points_in_cam(prepared, camera, selection)[kept])
        ).coefficients
        for camera in (PAPER_CAMERA, longer)
    ]
    shift = planes[1] - planes[0]
    added = np.diag(found.covariance - exact.covariance)[9:]
    # A step of 1 % of the focal length has a second order of about as much.
    np.testing.assert_allclose(np.sqrt(added), np.abs(shift), rtol=0.03)
    np.testing.assert_allclose(found.covariance[0, 9:], 20.0 * shift, rtol=0.03)
