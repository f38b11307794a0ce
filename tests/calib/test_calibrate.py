"""The doors `calibrate` and `calibrate_camera`: what they refuse, leave out and report."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import (
    LED_TARGET,
    PAPER_CAMERA,
    PAPER_SENSOR,
    PAPER_TARGET,
    SIZE,
    Setting,
    setting,
)

from calib import (
    CameraMismatch,
    CameraModel,
    CameraRole,
    Degenerate,
    Method,
    RigidTransform,
    Target,
    Termination,
    TooFewViews,
    calibrate,
    calibrate_camera,
)

METHODS = pytest.mark.parametrize("method", list(Method))


def drawn(rng, poses, noise_px=0.1, target=PAPER_TARGET):
    place = Setting(PAPER_SENSOR, target, tuple(poses))
    return place.views(rng, dots_px=noise_px, stripe_px=noise_px, stripe_count=40)


def slid(pose, shifts_mm):
    """Poses along one direction, all parallel."""
    return [
        RigidTransform(pose.rotation, pose.translation_mm + shift * np.array([0.05, -0.2, 1.0]))
        for shift in shifts_mm
    ]


@METHODS
def test_a_single_picture_is_too_few(rng, method):
    views = drawn(rng, setting(rng, 1).poses)
    with pytest.raises(TooFewViews, match="1 usable pictures for the light plane"):
        calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)


@METHODS
def test_no_pictures_at_all_are_too_few(method):
    with pytest.raises(TooFewViews, match="0 usable pictures"):
        calibrate([], PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)


def test_two_pictures_are_too_few_where_the_camera_is_unknown(rng):
    with pytest.raises(TooFewViews, match="at least 3 are needed"):
        calibrate(drawn(rng, setting(rng, 2).poses), PAPER_TARGET, **SIZE)


@METHODS
@pytest.mark.parametrize("noise_px", [0.0, 0.1, 1.0])
def test_pictures_of_one_pose_are_degenerate(rng, method, noise_px):
    views = drawn(rng, setting(rng, 1).poses * 6, noise_px)
    with pytest.raises(Degenerate, match="one line in space"):
        calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)


@pytest.mark.parametrize("noise_px", [0.0, 0.1])
def test_parallel_boards_leave_the_camera_undetermined(rng, noise_px):
    views = drawn(rng, slid(setting(rng, 1).poses[0], [-40.0, -20.0, 0.0, 20.0, 40.0]), noise_px)
    with pytest.raises(Degenerate, match="parallel"):
        calibrate(views, PAPER_TARGET, **SIZE)
    with pytest.raises(Degenerate, match="parallel"):
        calibrate_camera(views, PAPER_TARGET, **SIZE)


def test_boards_facing_the_camera_leave_the_focal_length_undetermined(rng):
    facing = [
        RigidTransform(np.eye(3), np.array([-45.0 + shift, -110.0 - shift / 5, 560.0 + shift]))
        for shift in (-20.0, 0.0, 20.0, 30.0)
    ]
    with pytest.raises(Degenerate, match=r"focal length|parallel"):
        calibrate_camera(drawn(rng, facing, noise_px=0.05), PAPER_TARGET, **SIZE)


@METHODS
def test_parallel_boards_give_a_plane_where_the_camera_is_known(rng, method):
    views = drawn(rng, slid(setting(rng, 1).poses[0], [-40.0, -20.0, 0.0, 20.0, 40.0]), 0.01)
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)
    error = found.sensor.plane.coefficients - PAPER_SENSOR.plane.coefficients
    assert np.abs(error[:3]).max() < 2e-3


def test_a_camera_of_another_picture_size_is_refused(rng):
    other = CameraModel.from_parameters(PAPER_CAMERA.parameters, width=1024, height=544)
    with pytest.raises(CameraMismatch, match="1024 x 544 px, the pictures are of 2048 x 1088"):
        calibrate(drawn(rng, setting(rng, 3).poses), PAPER_TARGET, **SIZE, camera=other)


def thinned(view, count):
    points = view.points
    return replace(
        view,
        points=replace(
            points,
            row=points.row[:count],
            col=points.col[:count],
            centre_px=points.centre_px[:count],
            sigma_px=points.sigma_px[:count],
            cause=points.cause[:count],
        ),
    )


@METHODS
@pytest.mark.parametrize(
    ("count", "reason"), [(5, "at least 6"), (10, "on one line")], ids=["few", "one row"]
)
def test_a_view_with_too_few_points_is_left_out_and_named(rng, method, count, reason):
    views = drawn(rng, setting(rng, 6).poses)
    views[2] = thinned(views[2], count)
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)
    assert reason in found.views[2].left_out
    assert found.views[2].dots is None
    assert any(warning.startswith("view 2 left out") for warning in found.warnings)
    assert [view.name for view in found.views] == [view.name for view in views]


def test_a_view_numbered_beyond_the_target_is_left_out(rng):
    views = drawn(rng, setting(rng, 6).poses)
    views[1] = replace(views[1], points=replace(views[1].points, row=views[1].points.row + 1))
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA)
    assert "row 10" in found.views[1].left_out


def test_when_all_views_fail_the_first_reason_is_told(rng):
    views = [thinned(view, 4) for view in drawn(rng, setting(rng, 3).poses)]
    with pytest.raises(TooFewViews, match="4 target points; at least 6"):
        calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA)


@METHODS
def test_a_view_without_a_stripe_serves_its_pose_only(rng, method):
    views = drawn(rng, setting(rng, 6).poses)
    views[0] = replace(views[0], stripe=None)
    views[1] = replace(views[1], stripe=views[1].stripe.select(np.arange(3)))
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA, method=method)
    assert found.views[0].cam_from_board is not None
    assert found.views[0].stripe is None
    assert len(found.views[1].stripe) == 3
    assert not found.views[1].stripe.used.any()
    assert any("view 1: its stripe has fewer than 5" in warning for warning in found.warnings)


@METHODS
@pytest.mark.parametrize("camera", [PAPER_CAMERA, None], ids=["camera held", "camera unknown"])
def test_every_method_reports_how_it_ended(rng, method, camera):
    views = drawn(rng, setting(rng, 8).poses)
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=camera, method=method)
    assert found.method is method
    assert found.solve.camera is (CameraRole.HELD if camera else CameraRole.ESTIMATED)
    assert found.solve.termination in (Termination.CONVERGED, Termination.CLOSED_FORM)
    assert found.solve.on_bound == ()
    sigma = np.sqrt(np.diag(found.sensor.covariance))
    assert (sigma[9:] > 0.0).all()
    assert (sigma[:6] > 0.0).all() == (camera is None)
    # The covariance of a unit normal has no part along the normal.
    normal = found.sensor.plane.normal_in_cam
    along = normal @ found.sensor.covariance[9:12, 9:12] @ normal
    assert along < 1e-3 * np.trace(found.sensor.covariance[9:12, 9:12])


def test_the_same_views_give_the_same_answer(rng):
    views = drawn(rng, setting(rng, 6).poses)
    one, other = (calibrate(views, PAPER_TARGET, **SIZE) for _ in range(2))
    np.testing.assert_array_equal(one.sensor.covariance, other.sensor.covariance)
    np.testing.assert_array_equal(one.sensor.plane.coefficients, other.sensor.plane.coefficients)


def test_sigmas_that_promise_too_much_are_told(rng):
    views = [
        replace(view, points=replace(view.points, sigma_px=view.points.sigma_px / 5.0))
        for view in drawn(rng, setting(rng, 6).poses)
    ]
    found = calibrate(views, PAPER_TARGET, **SIZE, camera=PAPER_CAMERA)
    assert found.solve.sigma_scale_dots == pytest.approx(5.0, rel=0.15)
    assert any("target points scatter" in warning for warning in found.warnings)


def test_a_wrong_pitch_moves_the_plane_and_is_not_hidden_by_the_fit(rng):
    """A target twice as large as told: nothing in the views can tell, all lengths double."""
    views = drawn(rng, setting(rng, 6).poses)
    found = calibrate(views, Target.parse("dots:10x10:20"), **SIZE, camera=PAPER_CAMERA)
    assert found.sensor.plane.offset_mm == pytest.approx(2 * PAPER_SENSOR.plane.offset_mm, rel=0.01)


@pytest.mark.parametrize("extra", [(), (6, 7), (8,)], ids=["k1 k2", "and p1 p2", "and k3"])
def test_a_camera_gets_the_distortion_terms_the_data_ask_for(rng, extra):
    parameters = PAPER_CAMERA.parameters
    parameters[list(extra)] = {6: 2e-3, 7: -1e-3, 8: 1.0}.get(extra[0] if extra else 0, 0.0)
    camera = CameraModel.from_parameters(parameters, **SIZE)
    sensor = replace(PAPER_SENSOR, camera=camera)
    views = setting(rng, 15, sensor=sensor).views(rng, dots_px=0.03, stripe_px=0.03)
    found = calibrate_camera(views, PAPER_TARGET, **SIZE).camera
    sigma = np.sqrt(np.diag(found.covariance))
    assert (sigma[list(extra)] > 0.0).all()
    error = found.parameters - parameters
    assert np.abs(error[sigma > 0.0] / sigma[sigma > 0.0]).max() < 4.5
    assert (error[sigma == 0.0] == 0.0).all()


def test_a_camera_report_has_the_view_of_every_picture(rng):
    views = drawn(rng, setting(rng, 6, target=LED_TARGET).poses, target=LED_TARGET)
    found = calibrate_camera(views, LED_TARGET, **SIZE)
    assert [view.name for view in found.views] == [view.name for view in views]
    assert all(view.stripe is None for view in found.views)
    # Two coordinates of 0.1 px each, less the six to seven parameters a view.
    assert found.rms_dots_px == pytest.approx(0.1 * np.sqrt(2.0), rel=0.1)
