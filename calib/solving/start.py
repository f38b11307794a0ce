"""Where a solve begins: usable views, their poses, their stripes in space, a first light plane.

Nothing here needs to be exact; everything here must survive false points and false pictures.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.camera import CameraModel
from calib.errors import Degenerate
from calib.homography import apply_homography, fit_homography_robustly, pose_from_homography
from calib.lines import fit_line_robustly, fit_plane
from calib.plane import LightPlane
from calib.rigid import RigidTransform
from calib.solving.robust import robust_limit
from calib.target import Target
from calib.views import StripePoints, TargetPoints, View

# A pose has six unknowns; six points leave as many residuals to judge it by.
LEAST_DOTS = 6
# A line has two unknowns; fewer than five points cannot outvote one false one.
LEAST_STRIPE_POINTS = 5
# A board whose points miss by this part of their spacing is not this board.
_MOST_MISS = 0.5
# Distortion bends a picture by up to this part of the target's extent in it.
_BEND = 0.01
# Of planes through two stripes; where a half are false, a quarter of them are through true ones.
_MOST_CANDIDATES = 500
# Stripes within so many robust standard deviations of the best plane are of the sheet; stripes
# without noise are off it by rounding.
_AGREEING, _ROUNDING_MM = 4.0, 1e-9
# Of the lines' extent: stripes that spread less across each other are one line in space.
_LEAST_SPREAD = 0.01
# ... as are stripes whose spread is no more than this many times what the poses' noise makes.
_LEAST_SPREAD_OVER_NOISE = 3.0


def usable_views(
    views: Sequence[View], target: Target, camera: CameraModel | None = None
) -> tuple[list[int], dict[int, str]]:
    """Sort views by index into usable ones and reasons against the others.

    With a camera, a view is usable only where the camera has a ray for each of its points.
    """
    reasons = {
        index: why_unusable(view, target) or (_why_unseen(view, camera) if camera else "")
        for index, view in enumerate(views)
    }
    usable = [index for index, reason in reasons.items() if not reason]
    return usable, {index: reason for index, reason in reasons.items() if reason}


def why_unusable(view: View, target: Target) -> str:
    """Return why a view cannot take part, in one line; empty if it can."""
    points = view.points
    if len(points) < LEAST_DOTS:
        return f"{len(points)} target points; at least {LEAST_DOTS} are needed"
    if not (points.row.max() < target.rows and points.col.max() < target.cols):
        return (
            f"a point at row {points.row.max()}, column {points.col.max()} of a target of "
            f"{target.rows} x {target.cols}"
        )
    if not min(points.row.min(), points.col.min()) >= 0:
        return "a point with a negative row or column"
    places = set(zip(points.row.tolist(), points.col.tolist(), strict=True))
    if len(places) < len(points):
        return "the same target point twice"
    board = points.points_mm(target.pitch_mm)[:, :2]
    try:
        # Distortion bends a map by some pixels; that must not set off the search for false points.
        homography = fit_homography_robustly(
            board, points.centre_px, _BEND * np.ptp(points.centre_px)
        )
    except Degenerate as reason:
        return str(reason)
    miss = np.median(np.linalg.norm(apply_homography(homography, board) - points.centre_px, axis=1))
    spacing = _spacing_px(homography, board, target.pitch_mm)
    if not miss <= _MOST_MISS * spacing:
        return (
            f"its points miss the target by {miss:.1f} px at a spacing of {spacing:.1f} px; "
            "is it this target?"
        )
    return ""


def _why_unseen(view: View, camera: CameraModel) -> str:
    stripe_px = np.empty((0, 2)) if view.stripe is None else view.stripe.centre_px
    seen_px = np.vstack([view.points.centre_px, stripe_px])
    folded = ~np.isfinite(camera.rays(seen_px)).all(axis=1)
    if not folded.any():
        return ""
    u, v = seen_px[folded][0]
    return (
        f"the camera's lens model folds the picture over at {u:.0f}, {v:.0f} px; is it the camera "
        "of these pictures?"
    )


def has_stripe(view: View) -> bool:
    """Tell whether a view has a stripe of enough points to be a line."""
    return view.stripe is not None and len(view.stripe) >= LEAST_STRIPE_POINTS


def typical_sigma_px(points: TargetPoints) -> float:
    """Return the median standard deviation of points along an axis."""
    return float(np.median(points.sigma_px))


def picture_homography(view: View, target: Target) -> FloatArray:
    """Return the map from the board, mm, to the picture, px, as if the lens did not distort.

    Raises
    ------
    Degenerate
        If the points lie on one line.
    """
    seen = view.points.centre_px
    board = view.points.points_mm(target.pitch_mm)[:, :2]
    # Distortion bends a map by some pixels; that must not set off the search for false points.
    sigma = max(typical_sigma_px(view.points), _BEND * float(np.ptp(seen, axis=0).max()))
    return fit_homography_robustly(board, seen, sigma)


def start_pose(view: View, target: Target, camera: CameraModel) -> RigidTransform:
    """Return the pose of a usable view, by decomposing its homography."""
    board = view.points.points_mm(target.pitch_mm)[:, :2]
    rays = camera.rays(view.points.centre_px)[:, :2]
    sigma = typical_sigma_px(view.points) / camera.fx
    return pose_from_homography(fit_homography_robustly(board, rays, sigma))


@dataclass(frozen=True, slots=True, eq=False)
class StripeLine:
    """The straight line of a stripe on its board.

    Attributes
    ----------
    ends_mm
        Shape (2, 3), the two ends, camera frame.
    agreeing
        Shape (N,), the stripe's points that lie on it.
    """

    ends_mm: FloatArray
    agreeing: BoolArray


def stripe_line(
    stripe: StripePoints, camera: CameraModel, cam_from_board: RigidTransform
) -> StripeLine:
    """Return the line of a stripe of at least two points, of which up to a half may be false."""
    rays = camera.rays(stripe.centre_px)[:, :2]
    line, agreeing = fit_line_robustly(rays)
    along = np.array([-line[1], line[0]])
    reach = rays[agreeing] @ along
    foot = -line[2] * line[:2]
    ends = foot + np.array([[reach.min()], [reach.max()]]) * along
    normal = cam_from_board.rotation[:, 2]
    rays_3d = np.column_stack([ends, np.ones(2)])
    depth = normal @ cam_from_board.translation_mm / (rays_3d @ normal)
    return StripeLine(rays_3d * depth[:, None], agreeing)


@dataclass(frozen=True, slots=True, eq=False)
class StartPlane:
    """A first light plane.

    Attributes
    ----------
    plane
        The light plane.
    agreeing
        Shape (M,), the stripes it was fitted to.
    """

    plane: LightPlane
    agreeing: BoolArray


def start_plane(stripes_mm: FloatArray, covariance_mm2: FloatArray) -> StartPlane:
    """Return the plane that most stripes lie in; up to a half of them may be false.

    Parameters
    ----------
    stripes_mm
        Shape (M, 2, 3), M >= 2, ends of each stripe in the camera frame.
    covariance_mm2
        Shape (M, 3, 3), of the middle of each stripe, by what is not known of its pose.

    Raises
    ------
    Degenerate
        If the stripes lie in one line in space, so that no plane is singled out.

    Notes
    -----
    Of the planes through two stripes each, the one with the smallest sum of distances is taken
    (least absolute deviations over the views), then fitted again to the stripes within four
    robust standard deviations.
    """
    pairs = _pairs(len(stripes_mm))
    planes = [fit_plane(stripes_mm[pair].reshape(-1, 3)) for pair in pairs]
    misses = np.array([_misses(stripes_mm, plane) for plane in planes])
    best = misses[np.argmin(misses.sum(axis=1))]
    agreeing = best <= robust_limit(best, _AGREEING) + _ROUNDING_MM
    _refuse_one_line(stripes_mm[agreeing], covariance_mm2[agreeing])
    plane = LightPlane.from_coefficients(fit_plane(stripes_mm[agreeing].reshape(-1, 3)))
    return StartPlane(plane, agreeing)


def _pairs(count: int) -> IntArray:
    """Return all pairs of so many, or as many as suffice, always the same; shape (N, 2)."""
    if count * (count - 1) // 2 <= _MOST_CANDIDATES:
        return np.array(list(combinations(range(count), 2)))
    draws = np.random.default_rng(0).integers(0, (count, count - 1), (_MOST_CANDIDATES, 2))
    return np.column_stack([draws[:, 0], (draws[:, 0] + 1 + draws[:, 1]) % count])


def _misses(stripes_mm: FloatArray, plane: FloatArray) -> FloatArray:
    return np.asarray(np.abs(stripes_mm @ plane[:3] + plane[3]).max(axis=1))


def _refuse_one_line(stripes_mm: FloatArray, covariance_mm2: FloatArray) -> None:
    ends = stripes_mm.reshape(-1, 3)
    _, values, axes = np.linalg.svd(ends - ends.mean(axis=0), full_matrices=False)
    spread = values / np.sqrt(len(ends))
    noise = np.sqrt(np.mean(axes[1] @ covariance_mm2 @ axes[1]))
    least = max(_LEAST_SPREAD * spread[0], _LEAST_SPREAD_OVER_NOISE * noise)
    if not spread[1] > least:
        raise Degenerate(
            f"the stripes of all pictures lie in one line in space (they spread {spread[1]:.2g} mm "
            f"across it, more than {least:.2g} mm is needed); move the target nearer and farther, "
            "so that the stripe falls on different parts of the sheet"
        )


def _spacing_px(homography: FloatArray, board: FloatArray, pitch_mm: float) -> float:
    middle = board.mean(axis=0)
    near = middle + np.array([[0.0, 0.0], [pitch_mm, 0.0], [0.0, pitch_mm]])
    seen = apply_homography(homography, near)
    return float(np.linalg.norm(seen[1:] - seen[0], axis=1).mean())
