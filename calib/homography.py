"""Maps between a plane and its picture, and the pose they hold."""

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.errors import Degenerate
from calib.rigid import RigidTransform

# Of 200 samples of 4, at least one is clean with a chance of 1 - 1e-5 at 50 % outliers.
_SAMPLES = 200
# Points within this many robust standard deviations are kept; of 100 clean ones all, mostly.
_KEEP = 4.0
# Twice the area of a triangle of centred points (mean distance sqrt 2) that counts as no line.
_LEAST_AREA = 0.05


def fit_homography(board_mm: FloatArray, picture: FloatArray) -> FloatArray:
    """Fit the map of a plane to its picture, by the normalised direct linear transform [1]_.

    Parameters
    ----------
    board_mm
        Shape (N, 2), N >= 4, points on the plane.
    picture
        Shape (N, 2), where they are seen: pixels or normalised coordinates, without distortion.

    Returns
    -------
    picture_from_board
        Shape (3, 3), unit Frobenius norm, positive third coordinate on the points.

    Raises
    ------
    Degenerate
        If the points do not determine the map, as on one line.

    References
    ----------
    .. [1] R. Hartley and A. Zisserman, "Multiple View Geometry in Computer Vision", 2nd ed.,
       Cambridge University Press, 2004, algorithm 4.2.
    """
    scale_board, scale_picture = _centring(board_mm), _centring(picture)
    design = _design(_apply_affine(scale_board, board_mm), _apply_affine(scale_picture, picture))
    _, values, right = np.linalg.svd(design, full_matrices=len(design) < 9)
    # The next-to-smallest singular value says how far the points are from a second solution.
    if not values[7] > 1e-6 * values[0]:
        raise Degenerate(
            f"{len(board_mm)} target points on one line; points of at least two rows and two "
            "columns are needed; show more of the target"
        )
    homography = np.linalg.solve(scale_picture, right[8].reshape(3, 3) @ scale_board)
    depth = np.median(board_mm @ homography[2, :2] + homography[2, 2])
    return np.asarray(homography * np.sign(depth) / np.linalg.norm(homography))


def fit_homography_robustly(board_mm: FloatArray, picture: FloatArray, sigma: float) -> FloatArray:
    """Fit like `fit_homography` where up to a half of the points may be false.

    Where the fit to all points leaves more than `sigma` explains, the map of four points with the
    smallest median residual (least median of squares) picks those that agree with it, and they
    are fitted again. The samples are always the same ones: the same points give the same map.

    Parameters
    ----------
    board_mm, picture
        As in `fit_homography`.
    sigma
        Predicted standard deviation of a point along each axis, in the unit of `picture`.

    Raises
    ------
    Degenerate
        As `fit_homography`.
    """
    plain = fit_homography(board_mm, picture)
    miss = np.linalg.norm(apply_homography(plain, board_mm) - picture, axis=1)
    if len(board_mm) <= 4 or miss.max() <= _KEEP * sigma:
        return plain
    scale_board, scale_picture = _centring(board_mm), _centring(picture)
    board, seen = _apply_affine(scale_board, board_mm), _apply_affine(scale_picture, picture)
    draws = np.random.default_rng(0).random((_SAMPLES, len(board)))
    samples = np.argpartition(draws, 4, axis=1)[:, :4]
    samples = samples[_spread(board[samples]) & _spread(seen[samples])]
    if len(samples) == 0:
        return plain
    misses = _misses(_through_four(board[samples], seen[samples]), board, seen)
    keep = _agreeing(misses[np.argmin(np.median(misses, axis=1))])
    return fit_homography(board_mm[keep], picture[keep])


def pose_from_homography(homography: FloatArray) -> RigidTransform:
    """Decompose the map of a board to normalised coordinates into its pose.

    Parameters
    ----------
    homography
        Shape (3, 3), from board mm to normalised coordinates, any scale; its third coordinate is
        positive on the board.

    Returns
    -------
    cam_from_board
        The rotation is the one nearest to (r1, r2, r1 x r2) in the Frobenius norm.

    Raises
    ------
    Degenerate
        If the two board axes fall on one direction, so that there is no rotation.
    """
    lengths = np.linalg.norm(homography[:, :2], axis=0)
    if not lengths.min() > 1e-9 * lengths.max():
        raise Degenerate("the target is seen edge-on; turn it towards the camera")
    columns = homography / lengths.mean()
    first, second = columns[:, 0], columns[:, 1]
    left, _, right = np.linalg.svd(np.column_stack([first, second, np.cross(first, second)]))
    turn = np.diag([1.0, 1.0, np.linalg.det(left @ right)])
    return RigidTransform(left @ turn @ right, columns[:, 2])


def apply_homography(homography: FloatArray, points: FloatArray) -> FloatArray:
    """Map points, shape (N, 2), by a homography."""
    mapped: FloatArray = points @ homography[:, :2].T + homography[:, 2]
    return np.asarray(mapped[:, :2] / mapped[:, 2:])


def _centring(points: FloatArray) -> FloatArray:
    """Map the points to zero mean and a mean distance of sqrt 2, for the condition of the fit."""
    centre = points.mean(axis=0)
    spread = np.linalg.norm(points - centre, axis=1).mean()
    scale = np.sqrt(2.0) / spread if spread > 0.0 else 1.0
    return np.array([
        [scale, 0.0, -scale * centre[0]],
        [0.0, scale, -scale * centre[1]],
        [0.0, 0.0, 1.0],
    ])


def _apply_affine(affine: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(points @ affine[:2, :2].T + affine[:2, 2])


def _design(board: FloatArray, picture: FloatArray) -> FloatArray:
    """Return the homogeneous equations, shape (..., 2N, 9), of points of shape (..., N, 2)."""
    ones = np.concatenate([board, np.ones((*board.shape[:-1], 1))], axis=-1)
    zeros = np.zeros_like(ones)
    rows_u = np.concatenate([ones, zeros, -picture[..., :1] * ones], axis=-1)
    rows_v = np.concatenate([zeros, ones, -picture[..., 1:] * ones], axis=-1)
    return np.concatenate([rows_u, rows_v], axis=-2)


def _through_four(board: FloatArray, picture: FloatArray) -> FloatArray:
    """Return the maps, shape (S, 3, 3), of sets of four points, shape (S, 4, 2)."""
    design = _design(board, picture)
    # The last entry is 1: centred points are never mapped to infinity by a sensible view.
    entries = np.linalg.solve(design[:, :, :8], -design[:, :, 8:])[:, :, 0]
    return np.column_stack([entries, np.ones(len(entries))]).reshape(-1, 3, 3)


def _spread(quads: FloatArray) -> BoolArray:
    """Tell which sets of four centred points, shape (S, 4, 2), have no three near one line."""
    triples = quads[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]]
    first, second = triples[:, :, 1] - triples[:, :, 0], triples[:, :, 2] - triples[:, :, 0]
    area = np.abs(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
    return np.asarray(area.min(axis=1) > _LEAST_AREA)


def _agreeing(miss: FloatArray) -> BoolArray:
    """Tell which points, by their distances of shape (N,), belong to the scatter of most."""
    # A Rayleigh variable has the median 1.1774 sigma; rounding alone must not sort points out.
    sigma = np.median(miss) / 1.1774 + 1e-12
    return np.asarray(miss <= _KEEP * sigma)


def _misses(maps: FloatArray, board: FloatArray, picture: FloatArray) -> FloatArray:
    """Return the distances, shape (S, N), between the mapped and the seen points."""
    ones = np.column_stack([board, np.ones(len(board))])
    mapped = ones @ maps.transpose(0, 2, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        miss: FloatArray = np.linalg.norm(mapped[..., :2] / mapped[..., 2:] - picture, axis=2)
    return np.nan_to_num(miss, nan=np.inf)
