"""Method `preplanar`: the baseline [11] of the paper, as the paper describes it.

Each view gives, through its homography, a pose; where the stripe crosses a column of dots, the
cross-ratio with three dots of the column gives a point on the target, and the pose carries it to
the camera frame. A plane is fitted to the points of all views: false points are found by random
samples, the others fitted by total least squares. Nothing is refined and no point is corrected.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.calibration import SolveReport, Termination
from calib.camera import PARAMETERS, CameraModel
from calib.errors import TooFewViews
from calib.homography import fit_homography, pose_from_homography
from calib.lines import fit_line, fit_plane
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.sensor import SENSOR_PARAMETERS
from calib.solving.crossings import DotLine, crossed_lines, crossings_mm
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import Linear, linearise_dots, linearise_stripe
from calib.solving.prepared import Answer, PointsAnswer, Prepared
from calib.solving.robust import robust_limit
from calib.target import Target
from calib.views import View

# Of 300 samples of 3 points, one is clean with a chance of 1 - 4e-18 at 50 % false points.
_SAMPLES = 300
# Points within this many robust standard deviations of the best sample's plane are kept.
_KEEP = 3.0
# Points without noise are off their plane by rounding.
_ROUNDING_MM = 1e-9
# Samples whose points lie in a line, beside the widest, tell no plane.
_LEAST_SPREAD = 1e-9
# Of central differences: small enough for the plane to follow straight, far above rounding.
_STEP_SIGMAS = 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Crossed:
    """Which lines of dots the stripes cross, told once: all else is smooth in the camera.

    Attributes
    ----------
    lines
        Per view; none where its stripe is not used.
    view
        Shape (N,), index of the view of each crossing, in order.
    """

    lines: tuple[tuple[DotLine, ...], ...]
    view: IntArray


def solve_preplanar(prepared: Prepared) -> Answer:
    """Solve the light plane from crossings of stripe and columns, the camera held.

    The covariance of the plane is the jackknife's over the views, plus what the camera's own
    covariance adds.

    Raises
    ------
    TooFewViews
        If the stripes cross fewer than two views' columns.
    """
    camera = prepared.camera
    crossed = crossed_by_stripes(prepared)
    points = points_in_cam(prepared, camera, crossed)
    kept = consensus(points)
    plane = LightPlane.from_coefficients(fit_plane(points[kept]))
    poses = [_pose(view, prepared.target, camera) for view in prepared.views]
    estimate = Estimate.start(camera, plane, poses)
    dots, stripe, stripe_in = _residuals(prepared, estimate, crossed.view[kept])
    own = _jackknife(points[kept], crossed.view[kept], plane)
    return Answer(
        camera=camera,
        plane=plane,
        poses=tuple(poses),
        covariance=sensor_covariance(
            prepared, own, _plane_by_camera(prepared, crossed, kept, plane)
        ),
        dots=dots,
        stripe=stripe,
        stripe_in=stripe_in,
        report=_report(prepared, dots, stripe),
    )


def crossed_by_stripes(prepared: Prepared) -> Crossed:
    """Tell which lines of dots each stripe crosses.

    Raises
    ------
    TooFewViews
        If the stripes cross fewer than two views' columns.
    """
    lines: list[tuple[DotLine, ...]] = []
    for index, view in enumerate(prepared.views):
        stripe = _stripe_line(prepared, prepared.camera, index)
        rays = prepared.camera.rays(view.points.centre_px)[:, :2]
        lines.append(
            ()
            if stripe is None
            else tuple(crossed_lines(view.points, prepared.target, rays, stripe))
        )
    if sum(len(own) > 0 for own in lines) < 2:
        raise TooFewViews(
            "the stripe crosses columns of three dots or more in fewer than two pictures; lay it "
            "across the target"
        )
    view_of = np.repeat(np.arange(len(lines)), [len(own) for own in lines])
    return Crossed(tuple(lines), view_of)


def _stripe_line(prepared: Prepared, camera: CameraModel, index: int) -> FloatArray | None:
    """Return a view's stripe as a line in normalised coordinates, by the points that agree."""
    stripe = prepared.views[index].stripe
    on_line = prepared.on_line[prepared.observations.stripe.view == index]
    if stripe is None or not on_line.any():
        return None
    return fit_line(camera.rays(stripe.centre_px[on_line])[:, :2])


def _pose(view: View, target: Target, camera: CameraModel) -> RigidTransform:
    board = view.points.points_mm(target.pitch_mm)[:, :2]
    return pose_from_homography(fit_homography(board, camera.rays(view.points.centre_px)[:, :2]))


def points_in_cam(prepared: Prepared, camera: CameraModel, crossed: Crossed) -> FloatArray:
    """Return the crossings in the camera frame, mm, shape (N, 3)."""
    parts = [np.empty((0, 3))]
    for index, (view, lines) in enumerate(zip(prepared.views, crossed.lines, strict=True)):
        stripe = _stripe_line(prepared, camera, index)
        if stripe is None:
            continue
        rays = camera.rays(view.points.centre_px)[:, :2]
        on_board = crossings_mm(lines, prepared.target, rays, stripe)
        pose = _pose(view, prepared.target, camera)
        parts.append(pose.apply(np.column_stack([on_board, np.zeros(len(on_board))])))
    return np.concatenate(parts)


def consensus(points_mm: FloatArray) -> BoolArray:
    """Tell which points lie on the plane of most, by the least median of distances."""
    draws = np.random.default_rng(0).random((_SAMPLES, len(points_mm)))
    first, second, third = np.moveaxis(points_mm[np.argpartition(draws, 2, axis=1)[:, :3]], 1, 0)
    normals = np.cross(second - first, third - first)
    length = np.linalg.norm(normals, axis=1)
    sound = length > _LEAST_SPREAD * length.max()
    normals = normals[sound] / length[sound, None]
    distance = np.abs(points_mm @ normals.T - np.einsum("ij,ij->i", normals, first[sound]))
    best = distance[:, np.argmin(np.median(distance, axis=0))]
    return np.asarray(best <= robust_limit(best, _KEEP) + _ROUNDING_MM)


def _residuals(
    prepared: Prepared, estimate: Estimate, believed_views: IntArray
) -> tuple[PointsAnswer, PointsAnswer, BoolArray]:
    layout = Layout((), plane=False)
    # The method knows nothing of a disc's picture.
    observations = replace(prepared.observations, radius_mm=0.0)
    seen, table = observations.dots.seen_px, observations.stripe
    dots: Linear = linearise_dots(observations, estimate, layout)
    stripe: Linear = linearise_stripe(table, estimate, layout)
    stripe_in = np.isin(np.arange(observations.count), believed_views)
    return (
        PointsAnswer(
            seen, np.linalg.norm(seen - dots.model_px, axis=1), np.ones(len(seen), dtype=bool)
        ),
        PointsAnswer(
            table.seen_px,
            np.abs(stripe.residual[:, 0] * table.sigma_px),
            stripe_in[table.view] & prepared.on_line,
        ),
        stripe_in,
    )


def sensor_covariance(prepared: Prepared, own: FloatArray, by_camera: FloatArray) -> FloatArray:
    """Return the sensor's covariance from the plane's own, (4, 4), and its slope by the camera."""
    count = len(PARAMETERS)
    camera = prepared.camera.covariance
    covariance = np.zeros((len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS)))
    covariance[:count, :count] = camera
    covariance[count:, :count] = by_camera @ camera
    covariance[:count, count:] = covariance[count:, :count].T
    covariance[count:, count:] = own + by_camera @ camera @ by_camera.T
    return covariance


def _jackknife(points_mm: FloatArray, view: IntArray, plane: LightPlane) -> FloatArray:
    """Return the covariance of (a, b, c, d), shape (4, 4), from leaving out one view at a time."""
    views = np.unique(view)
    answers = np.array([_near(fit_plane(points_mm[view != one]), plane) for one in views])
    centred = answers - answers.mean(axis=0)
    return np.asarray(centred.T @ centred * (len(views) - 1) / len(views))


def _plane_by_camera(
    prepared: Prepared, crossed: Crossed, kept: BoolArray, plane: LightPlane
) -> FloatArray:
    """Return d(a, b, c, d)/d(camera), shape (4, 9), by central differences; 0 where it is held."""
    sigma = np.sqrt(np.diag(prepared.camera.covariance))
    jacobian = np.zeros((4, len(sigma)))
    for index in np.flatnonzero(sigma > 0.0):
        step = _STEP_SIGMAS * sigma[index]
        ends = []
        for sign in (1.0, -1.0):
            parameters = prepared.camera.parameters
            parameters[index] += sign * step
            camera = CameraModel.from_parameters(
                parameters, width=prepared.camera.width, height=prepared.camera.height
            )
            points = points_in_cam(prepared, camera, crossed)
            ends.append(_near(fit_plane(points[kept]), plane))
        jacobian[:, index] = (ends[0] - ends[1]) / (2.0 * step)
    return jacobian


def _near(coefficients: FloatArray, plane: LightPlane) -> FloatArray:
    """Give a fitted plane the sign of another."""
    return np.asarray(coefficients * np.sign(coefficients[:3] @ plane.normal_in_cam))


def _report(prepared: Prepared, dots: PointsAnswer, stripe: PointsAnswer) -> SolveReport:
    seen = prepared.observations
    dot_sigma = np.sqrt((seen.dots.sigma_px**2).sum(axis=1))
    stripe_scale = (stripe.deviation_px / seen.stripe.sigma_px)[stripe.used]
    return SolveReport(
        termination=Termination.CLOSED_FORM,
        iterations=1,
        cost=0.0,
        sigma_scale_dots=float(np.sqrt(np.mean((dots.deviation_px / dot_sigma) ** 2))),
        sigma_scale_stripe=float(np.sqrt(np.mean(stripe_scale**2))),
        outlier_fraction_dots=0.0,
        outlier_fraction_stripe=float(1.0 - stripe.used.mean()),
        camera=prepared.role,
    )
