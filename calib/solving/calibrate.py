"""The doors of the solving half: from views to a camera, and to a laser sensor."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.calibration import Calibration, CameraCalibration, CameraRole, Method
from calib.camera import CameraModel
from calib.errors import CameraMismatch, TooFewViews
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.solving.assembly import misfits, solved_views
from calib.solving.camera_from_views import solve_camera
from calib.solving.credible_sigmas import solved_credibly
from calib.solving.deviation.method import solve_deviation
from calib.solving.joint.method import solve_jointly
from calib.solving.prepared import Answer, Prepared
from calib.solving.preplanar import solve_preplanar
from calib.solving.rival_stripes import settle_stripes
from calib.solving.start import LEAST_STRIPE_POINTS, has_stripe, usable_views
from calib.target import Target
from calib.views import View

_METHODS: Mapping[Method, Callable[[Prepared], Answer]] = {
    Method.PREPLANAR: solve_preplanar,
    Method.DEVIATION: solve_deviation,
    Method.JOINT: solve_jointly,
}
# A camera needs views of three orientations, a light plane two stripes.
_LEAST_CAMERA_VIEWS, _LEAST_STRIPES = 3, 2
# A view of whose points fewer than this part is believed does not show the target.
_LEAST_BELIEVED = 0.5


def calibrate_camera(
    views: Sequence[View], target: Target, *, width: int, height: int
) -> CameraCalibration:
    """Calibrate a camera from views of a target.

    Parameters
    ----------
    views
        What was seen; stripes are not looked at.
    target
        The target in the views.
    width, height
        Size of the pictures, px.

    Returns
    -------
    CameraCalibration
        fx, fy, cx, cy, k1, k2 always; p1, p2 and k3 where the data ask for them, else 0 and held.
        A view that cannot be used is left out and named.

    Raises
    ------
    TooFewViews
        If fewer than three views can be used.
    Degenerate
        If the views leave the focal length undetermined, as with parallel targets.
    NotConverged
        If the solve does not end.

    Notes
    -----
    Zhang's closed form starts a robust maximum-likelihood solve of all poses and the camera, each
    point weighted by its sigma; see ``decisions``.
    """
    return solved_credibly(
        lambda seen: (_camera_of(seen, target, width=width, height=height), seen), views
    )


def _camera_of(
    views: Sequence[View], target: Target, *, width: int, height: int
) -> CameraCalibration:
    usable, reasons = usable_views(views, target)
    while True:
        _require_views(usable, reasons, _LEAST_CAMERA_VIEWS, "the camera")
        chosen = [views[index] for index in usable]
        answer = solve_camera(chosen, target, width=width, height=height)
        failed = misfits(chosen, answer.dots, _LEAST_BELIEVED)
        if not failed:
            break
        reasons |= {usable[place]: reason for place, reason in failed.items()}
        usable = [index for index in usable if index not in reasons]
    return CameraCalibration(
        camera=answer.camera,
        rms_dots_px=answer.dots.rms_px,
        views=solved_views(views, usable, reasons, answer.poses, answer.dots, None, frozenset()),
        solve=answer.report,
        warnings=(*_left_out_warnings(views, reasons), *answer.warnings),
    )


def calibrate(
    views: Sequence[View],
    target: Target,
    *,
    width: int,
    height: int,
    camera: CameraModel | None = None,
    method: Method = Method.JOINT,
) -> Calibration:
    """Calibrate a laser sensor from views of a target crossed by its stripe.

    Parameters
    ----------
    views
        What was seen. A view without a stripe still serves poses and camera.
    target
        The target in the views.
    width, height
        Size of the pictures, px.
    camera
        Held where its covariance is zero; a prior where it is not; without one it is estimated
        from the same views.
    method
        How to solve.

    Returns
    -------
    Calibration
        A view that cannot be used is left out and named.

    Raises
    ------
    CameraMismatch
        If the camera is of another picture size.
    TooFewViews
        If fewer than two views with a stripe can be used, or three where the camera is unknown.
    Degenerate
        If the views leave the plane or the camera undetermined; told before solving.
    NotConverged
        If the solve does not end.
    """
    if camera is not None and (camera.width, camera.height) != (width, height):
        raise CameraMismatch(
            f"the camera is of {camera.width} x {camera.height} px, the pictures are of {width} x "
            f"{height}; calibrate the camera at the pictures' size"
        )

    def solve(seen: Sequence[View]) -> tuple[Calibration, Sequence[View]]:
        answer = _sensor_of(seen, target, camera, (width, height), method)
        return answer, answer.seen

    return solved_credibly(solve, views)


@dataclass(frozen=True, slots=True, eq=False)
class _Settled:
    """A solve in which all views fit that took part.

    Attributes
    ----------
    views
        All that were given, each with the stripe that is the laser's.
    usable, reasons
        Indices of those that took part; why the others did not.
    answer
        Of the method.
    warnings
        Of the camera that it began with.
    """

    views: Sequence[View]
    usable: Sequence[int]
    reasons: Mapping[int, str]
    answer: Answer
    warnings: tuple[str, ...]


def _sensor_of(
    views: Sequence[View],
    target: Target,
    camera: CameraModel | None,
    size: tuple[int, int],
    method: Method,
) -> Calibration:
    solved = _settled(views, target, camera, size, method)
    views, answer, reasons = solved.views, solved.answer, solved.reasons
    false_stripes = frozenset(
        index
        for index, believed in zip(solved.usable, answer.stripe_in, strict=True)
        if views[index].stripe is not None and not believed
    )
    return Calibration(
        sensor=LaserSensor(answer.camera, answer.plane, answer.covariance),
        method=method,
        rms_dots_px=answer.dots.rms_px,
        rms_stripe_px=answer.stripe.rms_px,
        views=solved_views(
            views, solved.usable, reasons, answer.poses, answer.dots, answer.stripe, false_stripes
        ),
        solve=answer.report,
        warnings=(
            *_left_out_warnings(views, reasons),
            *_stripe_warnings(views, sorted(false_stripes)),
            *solved.warnings,
            *answer.warnings,
        ),
        seen=tuple(views),
    )


def _settled(
    views: Sequence[View],
    target: Target,
    camera: CameraModel | None,
    size: tuple[int, int],
    method: Method,
) -> _Settled:
    """Solve, and again without the views that then do not fit, until all do."""
    usable, reasons = usable_views(views, target, camera)
    while True:
        start, role, near, warnings = _camera_to_start(views, usable, reasons, target, camera, size)
        views = settle_stripes(views, usable, target, start)
        _require_views(
            [index for index in usable if has_stripe(views[index])],
            reasons,
            _LEAST_STRIPES,
            "the light plane (target and stripe seen)",
        )
        chosen = [views[index] for index in usable]
        answer = _METHODS[method](Prepared.of(chosen, target, start, role, near))
        failed = misfits(chosen, answer.dots, _LEAST_BELIEVED)
        if not failed:
            return _Settled(views, usable, reasons, answer, warnings)
        reasons |= {usable[place]: reason for place, reason in failed.items()}
        usable = [index for index in usable if index not in reasons]


def _camera_to_start(
    views: Sequence[View],
    usable: Sequence[int],
    reasons: Mapping[int, str],
    target: Target,
    camera: CameraModel | None,
    size: tuple[int, int],
) -> tuple[CameraModel, CameraRole, tuple[RigidTransform, ...], tuple[str, ...]]:
    """Return the camera to begin with, its role, the poses if it was solved, and warnings."""
    if camera is not None:
        known = not np.diag(camera.covariance).any()
        return camera, CameraRole.HELD if known else CameraRole.PRIOR, (), ()
    _require_views(usable, reasons, _LEAST_CAMERA_VIEWS, "camera and light plane")
    chosen = [views[index] for index in usable]
    answer = solve_camera(chosen, target, width=size[0], height=size[1])
    return answer.camera, CameraRole.ESTIMATED, answer.poses, answer.warnings


def _require_views(
    usable: Sequence[int], reasons: Mapping[int, str], least: int, purpose: str
) -> None:
    if len(usable) >= least:
        return
    first = f"; the first one left out: {next(iter(reasons.values()))}" if reasons else ""
    raise TooFewViews(
        f"{len(usable)} usable pictures for {purpose}, at least {least} are needed{first}; add "
        "pictures of the target in other places"
    )


def _left_out_warnings(views: Sequence[View], reasons: Mapping[int, str]) -> tuple[str, ...]:
    return tuple(f"{views[index].name} left out: {reasons[index]}" for index in sorted(reasons))


def _stripe_warnings(views: Sequence[View], unused: Sequence[int]) -> tuple[str, ...]:
    return tuple(
        f"{views[index].name}: its stripe "
        + (
            "does not lie on the light plane of the others and was not used"
            if has_stripe(views[index])
            else f"has fewer than {LEAST_STRIPE_POINTS} points and was not used"
        )
        for index in unused
    )
