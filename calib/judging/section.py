"""The section of a cylinder by the sheet: an ellipse, fitted to points on it."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from calib.arrays import FloatArray, frozen

# Points farther off than this many sigmas count less: Cauchy's loss.
_USUAL = 2.5
_MOST_STEPS = 60
# Parts of the nominal radius. Held 60 degrees from square to the sheet, a cylinder's section is
# twice as long as wide: its lean is half the radius.
_MEAN_WITHIN = (0.3, 3.0)
_MOST_LEAN = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class SectionFit:
    r"""An ellipse through points of a section.

    Attributes
    ----------
    centre_mm
        Shape (2,), where the axis meets the sheet.
    form_mm
        Shape (3,): mean of the two semi-axes, and their half-difference times cosine and sine of
        twice the angle of the longer one. The radius is ``form[0] - hypot(form[1], form[2])``.
    residual_mm
        Shape (N,), distance of each point outwards, see `fit_section`.
    form_by_residual
        Shape (3, N), what the form owes to the distance of each point.
    """

    centre_mm: FloatArray
    form_mm: FloatArray
    residual_mm: FloatArray
    form_by_residual: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_mm", frozen(self.centre_mm, (2,), "centre_mm"))
        object.__setattr__(self, "form_mm", frozen(self.form_mm, (3,), "form_mm"))

    @property
    def radius_mm(self) -> float:
        """The minor semi-axis: the cylinder's radius, if it is a cylinder's section."""
        return radius_of_form(self.form_mm)

    @property
    def slope(self) -> FloatArray:
        """The axis is ``(slope[0], slope[1], 1)`` in the sheet's frame; one sign of the two."""
        return slope_of_form(self.form_mm)

    def points_mm(self, angle: FloatArray) -> FloatArray:
        """Return points of the section, shape (..., 2), at angles around its centre."""
        along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        reach = 1.0 / np.linalg.norm(along @ np.linalg.inv(_matrix(self.form_mm)), axis=-1)
        return np.asarray(self.centre_mm + along * reach[..., None])


def radius_of_form(form_mm: FloatArray) -> float:
    """Return the minor semi-axis of a form, see `SectionFit`."""
    return float(form_mm[0] - np.hypot(form_mm[1], form_mm[2]))


def slope_of_form(form_mm: FloatArray) -> FloatArray:
    """Return the slope of the axis, shape (2,), that makes a form; one sign of the two."""
    longer = 2.0 * np.hypot(form_mm[1], form_mm[2]) / radius_of_form(form_mm)
    angle = 0.5 * np.arctan2(form_mm[2], form_mm[1])
    steep = np.sqrt(longer * (2.0 + longer))
    return np.asarray(steep * np.array([np.cos(angle), np.sin(angle)]))


def form_of_slope(slope: FloatArray) -> FloatArray:
    """Return the form, shape (3,), that a cylinder of radius 1 has with a slope of its axis."""
    half_longer = 0.5 * (np.sqrt(1.0 + float(slope @ slope)) - 1.0)
    angle = 2.0 * np.arctan2(slope[1], slope[0])
    return np.array([
        1.0 + half_longer,
        half_longer * np.cos(angle),
        half_longer * np.sin(angle),
    ])


def fit_section(
    points_mm: FloatArray,
    sigma_mm: FloatArray,
    centre_mm: FloatArray,
    form_mm: FloatArray,
    *,
    unit_mm: float,
    axis_known: bool = False,
) -> SectionFit:
    r"""Fit an ellipse to points of a section.

    Parameters
    ----------
    points_mm
        Shape (N, 2), on the sheet.
    sigma_mm
        Shape (N,), standard deviation of each point's distance as told below.
    centre_mm, form_mm
        A first guess, shapes (2,) and (3,).
    unit_mm
        The nominal radius.
    axis_known
        The form keeps the shape of the guess; only its size is free.

    Returns
    -------
    SectionFit

    Notes
    -----
    A cylinder of radius R whose axis is (p, q, 1) in the frame of the sheet is cut in an ellipse
    with the semi-axes R, across (p, q), and :math:`R\sqrt{1 + p^2 + q^2}`, along it. With
    the matrix E of the form, :math:`|E^{-1} r|` is 1 on it; the distance of the point r from the
    centre is counted as :math:`R_0 (|E^{-1} r| - 1)` with the nominal radius: the distance from
    the mantle, but for the small difference of the two radii. Unlike the slope of the axis, the
    form is regular where the axis is square to the sheet. The sum of the robustly weighted
    squares (Cauchy's loss) is made least.
    """
    shapes = form_mm[:, None] / unit_mm if axis_known else np.eye(3)
    start = np.array([unit_mm]) if axis_known else form_mm

    def form(unknowns: FloatArray) -> FloatArray:
        return np.asarray(shapes @ unknowns[2:])

    def residuals(unknowns: FloatArray) -> FloatArray:
        return distances(points_mm, unknowns[:2], form(unknowns), unit_mm)[0] / sigma_mm

    def jacobian(unknowns: FloatArray) -> FloatArray:
        by_all = distances(points_mm, unknowns[:2], form(unknowns), unit_mm)[1]
        by_free = np.column_stack([by_all[:, :2], by_all[:, 2:] @ shapes])
        return np.asarray(by_free / sigma_mm[:, None])

    most = np.array([_MEAN_WITHIN[1], _MOST_LEAN, _MOST_LEAN])[: len(start)] * unit_mm
    least = np.array([_MEAN_WITHIN[0], -_MOST_LEAN, -_MOST_LEAN])[: len(start)] * unit_mm
    anywhere = np.full(2, np.inf)
    answer = least_squares(
        residuals,
        np.concatenate([centre_mm, np.clip(start, least, most)]),
        jac=jacobian,
        loss="cauchy",
        f_scale=_USUAL,
        x_scale="jac",
        bounds=(np.concatenate([-anywhere, least]), np.concatenate([anywhere, most])),
        max_nfev=_MOST_STEPS,
    )
    found = form(answer.x)
    residual = distances(points_mm, answer.x[:2], found, unit_mm)[0]
    usual = (residual / sigma_mm / _USUAL) ** 2
    # How the pull of a point grows with its distance: the second derivative of Cauchy's loss,
    # taken as none where it turns.
    weight = np.maximum(1.0 - usual, 0.0) / (1.0 + usual) ** 2
    design = jacobian(answer.x)
    normal = (design.T * weight) @ design
    gain = np.linalg.pinv(normal) @ (design.T * (weight / sigma_mm))
    return SectionFit(answer.x[:2], found, residual, -shapes @ gain[2:])


def distances(
    points_mm: FloatArray, centre_mm: FloatArray, form_mm: FloatArray, unit_mm: float
) -> tuple[FloatArray, FloatArray]:
    """Return distances as `fit_section` counts them, and d(distance)/d(centre, form), (N, 5)."""
    shrink = np.linalg.inv(_matrix(form_mm))
    arm = (points_mm - centre_mm) @ shrink
    length = np.linalg.norm(arm, axis=1)
    outwards = unit_mm * (arm / length[:, None]) @ shrink
    by_form = np.column_stack([
        (outwards * arm).sum(axis=1),
        outwards[:, 0] * arm[:, 0] - outwards[:, 1] * arm[:, 1],
        outwards[:, 0] * arm[:, 1] + outwards[:, 1] * arm[:, 0],
    ])
    return unit_mm * (length - 1.0), np.column_stack([-outwards, -by_form])


def distance_gradient(points_mm: FloatArray, fit: SectionFit, unit_mm: float) -> FloatArray:
    """Return d(distance)/d(point), shape (N, 2)."""
    return np.asarray(-distances(points_mm, fit.centre_mm, fit.form_mm, unit_mm)[1][:, :2])


def _matrix(form_mm: FloatArray) -> FloatArray:
    mean, straight, oblique = form_mm
    return np.array([[mean + straight, oblique], [oblique, mean - straight]])
