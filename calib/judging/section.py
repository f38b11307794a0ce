"""The section of a cylinder by the sheet, fitted to points on it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calib.arrays import FloatArray, frozen

# First guesses of the axis: tilted by this slope towards four directions. Exactly square to the
# sheet is no guess: there the distance does not change with the slope, to first order.
_START_SLOPE = 0.15
_DIRECTIONS = np.arange(4) * np.pi / 4.0
# Points farther off than this many sigmas count less: Cauchy's loss.
_USUAL = 2.5
# A section that is square to the axis has no slope to find: steps along it get nowhere.
_MOST_STEPS = 40
# No cylinder is held flatter than 60 degrees from square to the sheet.
_STEEPEST = 1.7


@dataclass(frozen=True, slots=True, eq=False)
class SectionFit:
    r"""A cylinder as its section shows it.

    Attributes
    ----------
    centre_mm
        Shape (2,), where the axis meets the sheet.
    slope
        Shape (2,): the axis is ``(slope[0], slope[1], 1)`` in the frame of the sheet, up to the
        sign of slope, which the section does not tell.
    radius_mm
        The radius.
    residual_mm
        Shape (N,), distance of each point from the mantle, outwards.
    radius_by_residual
        Shape (N,), what the radius owes to the distance of each point.
    """

    centre_mm: FloatArray
    slope: FloatArray
    radius_mm: float
    residual_mm: FloatArray
    radius_by_residual: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_mm", frozen(self.centre_mm, (2,), "centre_mm"))
        object.__setattr__(self, "slope", frozen(self.slope, (2,), "slope"))
        if not 0.0 < self.radius_mm < np.inf:
            raise ValueError(f"radius_mm must be positive, got {self.radius_mm}")

    @property
    def unknowns(self) -> FloatArray:
        """Centre, radius and slope, shape (5,)."""
        return np.concatenate([self.centre_mm, [self.radius_mm], self.slope])

    def points_mm(self, angle: FloatArray) -> FloatArray:
        """Return points of the section, shape (..., 2), at angles around its centre."""
        along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        lean = (along @ self.slope) ** 2 / (1.0 + self.slope @ self.slope)
        return np.asarray(
            self.centre_mm + along * (self.radius_mm / np.sqrt(1.0 - lean))[..., None]
        )


def fit_section(
    points_mm: FloatArray,
    sigma_mm: FloatArray,
    starts: Sequence[FloatArray],
    *,
    axis_known: bool = False,
) -> SectionFit:
    r"""Fit a cylinder to points of its section.

    Parameters
    ----------
    points_mm
        Shape (N, 2), on the sheet.
    sigma_mm
        Shape (N,), standard deviation of each point across the section.
    starts
        First guesses, shape (5,): centre, radius, slope; the best answer of all is taken.
    axis_known
        The slope of the guesses is held.

    Returns
    -------
    SectionFit

    Notes
    -----
    The distance of the point r = (x, y) - centre from the axis (p, q, 1) is

    .. math:: \sqrt{x^2 + y^2 - \frac{(p x + q y)^2}{1 + p^2 + q^2}},

    and the sum of its robustly weighted squares less the radius is made least. The section is an
    ellipse whose minor semi-axis is the radius. Of a short arc, that is nearly undetermined while
    the axis is unknown: a tilt, a shift and a smaller radius together move the points of an arc
    of 150 degrees by a twentieth of what they change the radius.
    """
    free = 3 if axis_known else 5

    def whole(unknowns: FloatArray, start: FloatArray) -> FloatArray:
        return np.concatenate([unknowns, start[free:]])

    def residuals(unknowns: FloatArray, start: FloatArray) -> FloatArray:
        return _distance(points_mm, whole(unknowns, start))[0] / sigma_mm

    def jacobian(unknowns: FloatArray, start: FloatArray) -> FloatArray:
        return _distance(points_mm, whole(unknowns, start))[1][:, :free] / sigma_mm[:, None]

    limit = np.array([np.inf, np.inf, np.inf, _STEEPEST, _STEEPEST])[:free]
    answers = [
        least_squares(
            residuals,
            start[:free],
            jac=jacobian,
            loss="cauchy",
            f_scale=_USUAL,
            x_scale="jac",
            bounds=(-limit, limit),
            max_nfev=_MOST_STEPS,
            args=(start,),
        )
        for start in starts
    ]
    best = min(answers, key=lambda answer: float(answer.cost))
    full = whole(best.x, starts[0])
    residual, by_all = _distance(points_mm, full)
    usual = (residual / sigma_mm / _USUAL) ** 2
    # How the pull of a point grows with its distance: the second derivative of Cauchy's loss,
    # taken as none where it turns.
    weight = np.maximum(1.0 - usual, 0.0) / ((1.0 + usual) * sigma_mm) ** 2
    design = by_all[:, :free]
    gain = np.linalg.pinv((design.T * weight) @ design)[2] @ (design.T * weight)
    return SectionFit(full[:2], full[3:], float(full[2]), residual, -gain)


def first_guesses(centre_mm: FloatArray, radius_mm: float) -> list[FloatArray]:
    """Return guesses, each of shape (5,), with the axis leaning towards four directions."""
    lean = _START_SLOPE * np.column_stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])
    return [np.array([*centre_mm, radius_mm, *each], dtype=np.float64) for each in lean]


def distance_gradient(points_mm: FloatArray, fit: SectionFit) -> FloatArray:
    """Return d(distance from the axis)/d(point), shape (N, 2)."""
    return np.asarray(-_distance(points_mm, fit.unknowns)[1][:, :2])


def _distance(points_mm: FloatArray, unknowns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distances from the mantle and d(distance)/d(centre, radius, slope), (N, 5)."""
    arm, slope = points_mm - unknowns[:2], unknowns[3:]
    along, scale = arm @ slope, 1.0 + slope @ slope
    distance = np.sqrt((arm**2).sum(axis=1) - along**2 / scale)
    by_centre = along[:, None] * slope / scale - arm
    by_slope = along[:, None] ** 2 * slope / scale**2 - along[:, None] * arm / scale
    by_radius = -np.ones(len(arm))
    jacobian = np.column_stack([
        by_centre / distance[:, None],
        by_radius,
        by_slope / distance[:, None],
    ])
    return distance - unknowns[2], jacobian
