"""Ellipses: the outlines of dots seen at an angle."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Ellipses:
    """N ellipses ``(p - centre)' form (p - centre) = 1``.

    Attributes
    ----------
    centre_px
        Shape (N, 2).
    form
        Shape (N, 3): the entries q11, q12, q22 of the symmetric matrix, 1 / px^2.
    """

    centre_px: FloatArray
    form: FloatArray

    def __len__(self) -> int:
        return len(self.centre_px)

    @classmethod
    def circles(cls, centre_px: FloatArray, radius_px: FloatArray) -> Self:
        """Make circles."""
        square = 1.0 / np.asarray(radius_px, dtype=np.float64) ** 2
        return cls(np.asarray(centre_px), np.column_stack([square, 0.0 * square, square]))

    def picked(self, index: IntArray | BoolArray) -> "Ellipses":
        """Return those an index array or a mask picks."""
        return Ellipses(self.centre_px[index], self.form[index])

    def joined(self, other: "Ellipses") -> "Ellipses":
        """Return these and then those."""
        return Ellipses(
            np.concatenate([self.centre_px, other.centre_px]),
            np.concatenate([self.form, other.form]),
        )

    def level(self, offset_px: FloatArray) -> FloatArray:
        """Return how far out points are: 1 on the outline, 0 in the centre.

        Parameters
        ----------
        offset_px
            Shape (N, K, 2), from the centres.

        Returns
        -------
        level
            Shape (N, K).
        """
        x, y = offset_px[..., 0], offset_px[..., 1]
        q11, q12, q22 = (self.form[:, i, None] for i in range(3))
        square = q11 * x * x + 2.0 * q12 * x * y + q22 * y * y
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    @property
    def axes_px(self) -> FloatArray:
        """Half axes, the shorter first, shape (N, 2); NaN where the form is no ellipse."""
        q11, q12, q22 = self.form.T
        mean, half = 0.5 * (q11 + q22), np.hypot(0.5 * (q11 - q22), q12)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.column_stack([1.0 / np.sqrt(mean + half), 1.0 / np.sqrt(mean - half)])

    @property
    def radius_px(self) -> FloatArray:
        """Radius of the circle of the same area, shape (N,)."""
        return np.asarray(np.sqrt(self.axes_px[:, 0] * self.axes_px[:, 1]))


def fit_ellipses(points_px: FloatArray, weight: FloatArray) -> Ellipses:
    """Fit an ellipse to each row of weighted points, by least squares on the conic.

    Parameters
    ----------
    points_px
        Shape (N, K, 2), around the origin: the caller takes a first centre off.
    weight
        Shape (N, K).

    Returns
    -------
    Ellipses
        Centres are relative to the origin; a form that is no ellipse has NaN axes.
    """
    scale = np.sqrt((points_px**2).sum(axis=2).mean(axis=1))[:, None, None]
    x, y = np.moveaxis(points_px / scale, 2, 0)
    design = np.stack([x * x, 2.0 * x * y, y * y, x, y], axis=2)
    weighted = design * weight[:, :, None]
    normal = weighted.transpose(0, 2, 1) @ design + 1e-6 * np.eye(5)
    a, b, c, d, e = np.linalg.solve(normal, weighted.sum(axis=1)[:, :, None])[:, :, 0].T
    determinant = a * c - b * b
    with np.errstate(divide="ignore", invalid="ignore"):
        u, v = 0.5 * (b * e - c * d) / determinant, 0.5 * (b * d - a * e) / determinant
        size = 1.0 + a * u * u + 2.0 * b * u * v + c * v * v
        form = np.column_stack([a, b, c]) / (size[:, None] * scale[:, 0] ** 2)
    form[~(determinant > 0.0)] = np.nan
    return Ellipses(np.column_stack([u, v]) * scale[:, 0], form)
