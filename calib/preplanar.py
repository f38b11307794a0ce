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
from calib.cross_ratio import place_by_cross_ratio
from calib.errors import TooFewViews
from calib.homography import fit_homography, pose_from_homography
from calib.joint.parameters import Estimate, Layout
from calib.joint.residuals import Linear, linearise_dots, linearise_stripe
from calib.lines import fit_line, fit_line_robustly, fit_plane
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.sensor import SENSOR_PARAMETERS
from calib.solving import Answer, PointsAnswer, Prepared
from calib.start import has_stripe
from calib.target import Target
from calib.views import View

# Of 300 samples of 3 points, one is clean with a chance of 1 - 4e-18 at 50 % false points.
_SAMPLES = 300
# Points within this many robust standard deviations of the best sample's plane are kept.
_KEEP = 3.0
# A crossing this many pitches beyond the outer dots is not on the target.
_BEYOND = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Crossings:
    """Where stripes cross columns of dots, all views together.

    Attributes
    ----------
    view
        Shape (N,), index of the view.
    in_cam_mm
        Shape (N, 3), camera frame.
    """

    view: IntArray
    in_cam_mm: FloatArray


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
    crossings = _all_crossings(prepared, camera)
    kept = _consensus(crossings.in_cam_mm)
    plane = LightPlane.from_coefficients(fit_plane(crossings.in_cam_mm[kept]))
    poses = _poses(prepared, camera)
    estimate = Estimate.start(camera, plane, poses)
    dots, stripe, stripe_in = _residuals(prepared, estimate, crossings.view[kept])
    return Answer(
        camera=camera,
        plane=plane,
        poses=tuple(poses),
        covariance=_covariance(prepared, crossings, kept, plane),
        dots=dots,
        stripe=stripe,
        stripe_in=stripe_in,
        report=_report(prepared, dots, stripe),
    )


def crossings_on_board(view: View, target: Target, camera: CameraModel) -> FloatArray:
    """Return where the stripe crosses the columns of dots, or the rows where it runs along columns.

    Parameters
    ----------
    view
        A view with a stripe.
    target, camera
        The target in it; the camera, for the undistorted picture.

    Returns
    -------
    crossings_mm
        Shape (N, 2), on the target; a column with fewer than three dots gives none.
    """
    if view.stripe is None or not has_stripe(view):
        return np.empty((0, 2))
    stripe, _ = fit_line_robustly(camera.rays(view.stripe.centre_px)[:, :2])
    seen = camera.rays(view.points.centre_px)[:, :2]
    row, col = view.points.row, view.points.col
    by_column = _crossings_of(seen, col, row, stripe, target.rows) * target.pitch_mm
    if len(by_column) == target.cols:
        return by_column
    by_row = _crossings_of(seen, row, col, stripe, target.cols) * target.pitch_mm
    return by_column if len(by_column) >= len(by_row) else by_row[:, ::-1]


def _crossings_of(
    seen: FloatArray, line_of: IntArray, place_on: IntArray, stripe: FloatArray, count: int
) -> FloatArray:
    """Return (line, place) of the crossings in pitches, shape (N, 2)."""
    found = []
    for line in np.unique(line_of):
        own = np.flatnonzero(line_of == line)
        if len(own) < 3:
            continue
        place = _crossing(seen[own], place_on[own], stripe)
        if -_BEYOND <= place <= count - 1 + _BEYOND:
            found.append((float(line), place))
    return np.array(found).reshape(-1, 2)


def _crossing(seen: FloatArray, place: IntArray, stripe: FloatArray) -> float:
    """Return the place of a crossing along one column, by its two outer dots and the middle one."""
    column = fit_line(seen)
    point = np.cross(column, stripe)
    if not abs(point[2]) > 1e-12:
        return np.inf
    along = np.array([-column[1], column[0]])
    order = np.argsort(place)[[0, len(place) // 2, -1]]
    crossing = place_by_cross_ratio(
        place[order].astype(np.float64), seen[order] @ along, point[:2] / point[2] @ along
    )
    return float(crossing)


def _poses(prepared: Prepared, camera: CameraModel) -> list[RigidTransform]:
    poses = []
    for points in (view.points for view in prepared.views):
        board = points.points_mm(prepared.target.pitch_mm)[:, :2]
        rays = camera.rays(points.centre_px)[:, :2]
        poses.append(pose_from_homography(fit_homography(board, rays)))
    return poses


def _all_crossings(prepared: Prepared, camera: CameraModel) -> _Crossings:
    parts = [crossings_on_board(view, prepared.target, camera) for view in prepared.views]
    if sum(len(part) > 0 for part in parts) < 2:
        raise TooFewViews(
            "the stripe crosses three or more dots' columns in fewer than two pictures; lay it "
            "across the target"
        )
    return _Crossings(
        view=np.repeat(np.arange(len(parts)), [len(part) for part in parts]),
        in_cam_mm=np.concatenate([
            pose.apply(np.column_stack([part, np.zeros(len(part))]))
            for pose, part in zip(_poses(prepared, camera), parts, strict=True)
        ]),
    )


def _consensus(points_mm: FloatArray) -> BoolArray:
    """Tell which points lie on the plane of most, by the least median of distances."""
    draws = np.random.default_rng(0).random((_SAMPLES, len(points_mm)))
    first, second, third = np.moveaxis(points_mm[np.argpartition(draws, 2, axis=1)[:, :3]], 1, 0)
    normals = np.cross(second - first, third - first)
    length = np.linalg.norm(normals, axis=1)
    sound = length > 1e-9 * length.max()
    normals = normals[sound] / length[sound, None]
    distance = np.abs(points_mm @ normals.T - np.einsum("ij,ij->i", normals, first[sound]))
    best = distance[:, np.argmin(np.median(distance, axis=0))]
    return np.asarray(best <= _KEEP * np.median(best) / 0.6745 + 1e-9)


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
            stripe_in[table.view] & _on_lines(prepared),
        ),
        stripe_in,
    )


def _on_lines(prepared: Prepared) -> BoolArray:
    """Tell the stripe points that agree with the line of their view, shape (N,)."""
    masks = [np.empty(0, dtype=bool)]
    for view in prepared.views:
        if view.stripe is None:
            continue
        rays = prepared.camera.rays(view.stripe.centre_px)[:, :2]
        enough = has_stripe(view)
        masks.append(fit_line_robustly(rays)[1] if enough else np.zeros(len(rays), dtype=bool))
    return np.concatenate(masks)


def _covariance(
    prepared: Prepared, crossings: _Crossings, kept: BoolArray, plane: LightPlane
) -> FloatArray:
    count = len(PARAMETERS)
    by_camera = _plane_by_camera(prepared, plane)
    covariance = np.zeros((len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS)))
    camera = prepared.camera.covariance
    covariance[:count, :count] = camera
    covariance[count:, :count] = by_camera @ camera
    covariance[:count, count:] = covariance[count:, :count].T
    own = _jackknife(crossings, kept, plane)
    covariance[count:, count:] = own + by_camera @ camera @ by_camera.T
    return covariance


def _jackknife(crossings: _Crossings, kept: BoolArray, plane: LightPlane) -> FloatArray:
    """Return the covariance of (a, b, c, d), shape (4, 4), from leaving out one view at a time."""
    views = np.unique(crossings.view[kept])
    answers = np.array([
        _near(fit_plane(crossings.in_cam_mm[kept & (crossings.view != view)]), plane)
        for view in views
    ])
    centred = answers - answers.mean(axis=0)
    return np.asarray(centred.T @ centred * (len(views) - 1) / len(views))


def _plane_by_camera(prepared: Prepared, plane: LightPlane) -> FloatArray:
    """Return d(a, b, c, d)/d(camera), shape (4, 9), by central differences; 0 where it is held."""
    sigma = np.sqrt(np.diag(prepared.camera.covariance))
    jacobian = np.zeros((4, len(sigma)))
    for index in np.flatnonzero(sigma > 0.0):
        # A small step, so that no point changes sides.
        step = 1e-3 * sigma[index]
        ends = []
        for sign in (1.0, -1.0):
            parameters = prepared.camera.parameters
            parameters[index] += sign * step
            camera = CameraModel.from_parameters(
                parameters, width=prepared.camera.width, height=prepared.camera.height
            )
            moved = _all_crossings(prepared, camera).in_cam_mm
            ends.append(_near(fit_plane(moved[_consensus(moved)]), plane))
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
