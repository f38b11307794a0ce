"""Where the stripe crosses the lines of a target's grid: in the picture and on the target.

The target is the gauge here. Its place in the picture is told by a free homography rather than
by a pose, so that of the sensor under test only the lens takes part in it.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import least_squares

from calib.arrays import BoolArray, FloatArray, read_only
from calib.camera import CameraModel
from calib.homography import apply_homography, fit_homography_robustly
from calib.lines import fit_line_robustly
from calib.solving.joint.discs import ellipse_centres, lens_shifts
from calib.solving.start import start_pose
from calib.target import Target
from calib.views import StripePoints, View

# A lit line of the grid reaches this far beyond its outermost points, in pitches.
_BEYOND = 0.5
# Points farther off than this many sigmas count less: Cauchy's loss.
_USUAL = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Crossings:
    """Crossings of one stripe with the columns of a target, or with its rows.

    Attributes
    ----------
    lines
        What was crossed.
    board_mm
        Shape (K, 2), on the target, in the order of the lines.
    rays_in_cam
        Shape (K, 3), (x, y, 1): where the camera sees them.
    """

    lines: Literal["columns", "rows"]
    board_mm: FloatArray
    rays_in_cam: FloatArray

    def __post_init__(self) -> None:
        for name in ("board_mm", "rays_in_cam"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.board_mm)


def grid_crossings(view: View, target: Target, camera: CameraModel) -> Crossings:
    """Return where the stripe crosses the target's columns, or its rows where those are more.

    Parameters
    ----------
    view
        A view with a stripe of at least two points.
    target, camera
        The target in it; the camera, whose lens is undone.

    Returns
    -------
    Crossings
        Within the target, half a pitch around it, and the stripe's own ends; perhaps none.

    Raises
    ------
    Degenerate
        If the target's points lie on one line.
    ValueError
        If the view has no stripe.
    """
    if view.stripe is None:
        raise ValueError(f"{view.name} has no stripe")
    picture_from_board = board_homography(view, target, camera)
    stripe, used = _stripe_line(view.stripe, camera)
    # A line maps by the transpose of the map of points.
    on_board = picture_from_board.T @ stripe
    board_from_picture: FloatArray = np.linalg.inv(picture_from_board).astype(np.float64)
    ends = apply_homography(board_from_picture, camera.rays(view.stripe.centre_px)[used, :2])
    by_column = _crossed(on_board, ends, target, axis=0)
    by_row = _crossed(on_board, ends, target, axis=1)
    columns = len(by_column) >= len(by_row)
    board_mm = by_column if columns else by_row
    seen = apply_homography(picture_from_board, board_mm)
    return Crossings(
        "columns" if columns else "rows", board_mm, np.column_stack([seen, np.ones(len(seen))])
    )


def board_homography(view: View, target: Target, camera: CameraModel) -> FloatArray:
    """Return the map from the target, mm, to normalised coordinates, shape (3, 3).

    Each point is weighted by its sigma, false ones lose their weight (Cauchy's loss), and the
    shift of a disc's centroid off the picture of its centre is taken off first.

    Raises
    ------
    Degenerate
        If the points lie on one line.
    """
    board = view.points.points_mm(target.pitch_mm)
    seen_px = view.points.centre_px - _centroid_shift_px(view, target, camera, board)
    rays, by_pixel, _ = camera.rays_with_jacobians(seen_px)
    sigma = view.points.sigma_px * np.abs(by_pixel[:, [0, 1], [0, 1]])
    start = fit_homography_robustly(board[:, :2], rays[:, :2], float(np.median(sigma)))

    def residuals(entries: FloatArray) -> FloatArray:
        mapped = apply_homography(_full(entries), board[:, :2])
        return np.asarray(((mapped - rays[:, :2]) / sigma).ravel())

    # The last entry is the depth of the target's origin, which no view has at zero.
    answer = least_squares(
        residuals,
        (start / start[2, 2]).ravel()[:8],
        loss="cauchy",
        f_scale=_USUAL,
        x_scale="jac",
    )
    return _full(answer.x)


def _full(entries: FloatArray) -> FloatArray:
    return np.array([*entries, 1.0], dtype=np.float64).reshape(3, 3)


def _centroid_shift_px(
    view: View, target: Target, camera: CameraModel, board_mm: FloatArray
) -> FloatArray:
    """Return how far each disc's centroid lies off the picture of its centre, shape (N, 2)."""
    radius_mm = _dot_radius_mm(view, target)
    if radius_mm is None:
        return np.zeros((len(board_mm), 2))
    cam_from_board = start_pose(view, target, camera)
    middle = cam_from_board.apply(board_mm)
    normal = np.tile(cam_from_board.rotation[:, 2], (len(middle), 1))
    centre = ellipse_centres(middle, normal, radius_mm)
    axes = np.tile(cam_from_board.rotation[:, :2], (len(middle), 1, 1))
    by_lens = lens_shifts(centre, axes, radius_mm, camera.parameters)
    return camera.project(centre) + by_lens - camera.project(middle)


def _dot_radius_mm(view: View, target: Target) -> float | None:
    """Return the radius of the dots: as given, else as the picture shows it; None if neither."""
    if target.kind != "dots":
        return None
    if target.diameter_mm is not None:
        return target.diameter_mm / 2.0
    return None if view.dot_radius is None else view.dot_radius * target.pitch_mm


def _stripe_line(stripe: StripePoints, camera: CameraModel) -> tuple[FloatArray, BoolArray]:
    """Return the stripe's line in normalised coordinates, weighted, and the points on it.

    Where sheet and target are planes the line is straight, once the lens is undone.
    """
    rays, by_pixel, _ = camera.rays_with_jacobians(stripe.centre_px)
    line, agreeing = fit_line_robustly(rays[:, :2])
    across = np.einsum("i,nij,nj->n", line[:2], by_pixel[:, :2], stripe.normal)
    points, weight = rays[agreeing, :2], 1.0 / (across * stripe.sigma_px)[agreeing] ** 2
    centre = weight @ points / weight.sum()
    _, axes = np.linalg.eigh(((points - centre).T * weight) @ (points - centre))
    normal = axes[:, 0]
    return np.append(normal, -normal @ centre), agreeing


def _crossed(line: FloatArray, ends: FloatArray, target: Target, axis: int) -> FloatArray:
    """Return crossings, shape (K, 2), with the grid lines on which coordinate `axis` is fixed."""
    count, across = (target.cols, target.rows) if axis == 0 else (target.rows, target.cols)
    if not abs(line[1 - axis]) > 0.0:
        return np.empty((0, 2))
    fixed = np.arange(count) * target.pitch_mm
    free = -(line[axis] * fixed + line[2]) / line[1 - axis]
    reach = np.array([-_BEYOND, across - 1.0 + _BEYOND]) * target.pitch_mm
    inside = (free >= reach[0]) & (free <= reach[1])
    lit = (fixed >= ends[:, axis].min()) & (fixed <= ends[:, axis].max())
    crossed = np.empty((count, 2))
    crossed[:, axis], crossed[:, 1 - axis] = fixed, free
    return np.asarray(crossed[inside & lit])
