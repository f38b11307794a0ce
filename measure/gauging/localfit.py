"""A short piece of the profile, smoothed: a parabola in the frame of its own tangent."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray
from measure.gauging.estimate import Estimate

_MIN_POINTS = 6
_MIN_SPAN = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class LocalFit:
    r"""Weighted parabola through the points of a window.

    Attributes
    ----------
    index
        Shape (K,), the points used, of ``count``.
    origin_mm, tangent, normal
        Shape (2,), the local frame in (a, r).
    coefficients
        Shape (3,), f(s) = c0 + c1 s + c2 s².
    solver
        Shape (3, K): coefficients = solver @ f of the points.
    along_mm
        Shape (K,), s of the points.

    Notes
    -----
    With s along the tangent and f(s) along the normal, a circle of radius R leaves a quartic rest
    of s⁴ / 8R³, of which a window of half-width w makes a bias of 3 w⁴ / (280 R³) at its middle:
    0.5 µm for w = 3, R = 12 mm.
    """

    index: IntArray
    count: int
    origin_mm: FloatArray
    tangent: FloatArray
    normal: FloatArray
    coefficients: FloatArray
    solver: FloatArray
    along_mm: FloatArray

    @classmethod
    def around(
        cls, points_mm: FloatArray, weight: FloatArray, place_mm: FloatArray, half_window_mm: float
    ) -> "LocalFit | None":
        """Fit the points within a distance of a place, or return None where they do not suffice.

        Parameters
        ----------
        points_mm
            Shape (N, 2), (a, r).
        weight
            Shape (N,), inverse variance across the profile.
        place_mm
            Shape (2,).
        half_window_mm
            Greatest distance of the points used.
        """
        index = np.flatnonzero(np.hypot(*(points_mm - place_mm).T) <= half_window_mm)
        if len(index) < _MIN_POINTS:
            return None
        near, w = points_mm[index], weight[index]
        origin = w @ near / w.sum()
        offset = near - origin
        _, axes = np.linalg.eigh((offset * w[:, None]).T @ offset)
        tangent, normal = axes[:, 1], axes[:, 0]
        s, f = offset @ tangent, offset @ normal
        # Too short a piece fixes no parabola: where a profile ends, half a window is left of it.
        if not np.ptp(s) >= _MIN_SPAN * half_window_mm:
            return None
        design = np.column_stack([np.ones(len(s)), s, s * s])
        weighted = design.T * w
        solver = np.linalg.solve(weighted @ design, weighted)
        return cls(index, len(points_mm), origin, tangent, normal, solver @ f, solver, s)

    def covers(self, s: float) -> bool:
        """Whether the place s lies between the points, not beyond them."""
        return bool(self.along_mm.min() <= s <= self.along_mm.max())

    def away_mm(self, s: float) -> float:
        """Return how far s lies from the nearest point, beyond the ends or in a gap."""
        return float(np.abs(self.along_mm - s).min())

    def widest_gap_mm(self) -> float:
        """Return the greatest distance along the tangent between neighbouring points."""
        return float(np.diff(np.sort(self.along_mm)).max())

    def point(self, s: float) -> FloatArray:
        """Return the place (a, r) at s."""
        c0, c1, c2 = self.coefficients
        return np.asarray(
            self.origin_mm + s * self.tangent + (c0 + s * (c1 + s * c2)) * self.normal
        )

    def direction(self, s: float) -> FloatArray:
        """Return the derivative of the place by s."""
        return np.asarray(
            self.tangent + (self.coefficients[1] + 2.0 * s * self.coefficients[2]) * self.normal
        )

    def crossing(self, axis: int, level_mm: float) -> float | None:
        """Return the s nearest the middle where coordinate `axis` (0: a, 1: r) takes a value."""
        c0, c1, c2 = self.coefficients
        along, across = self.tangent[axis], self.normal[axis]
        constant = self.origin_mm[axis] + c0 * across - level_mm
        roots = np.roots([c2 * across, along + c1 * across, constant])
        real = roots[np.isreal(roots)].real
        return float(real[np.argmin(np.abs(real))]) if len(real) else None

    def crest(self) -> float | None:
        """Return the s where r is greatest, or None where the parabola has no such place."""
        along, across = self.tangent[1], self.normal[1]
        curvature = 2.0 * self.coefficients[2] * across
        if not curvature < 0.0:
            return None
        return float(-(along + self.coefficients[1] * across) / curvature)

    def read(self, axis: int, s: float) -> Estimate:
        """Return coordinate `axis` at s, the other coordinate held."""
        return Estimate(float(self.point(s)[axis]), self._normal_gradient(s) * self.gain(axis, s))

    def gain(self, axis: int, s: float) -> float:
        """Return the change of coordinate `axis`, the other held, for a shift along the normal."""
        held = 1 - axis
        direction = self.direction(s)
        return float(self.normal[axis] - self.normal[held] * direction[axis] / direction[held])

    def slope(self, axis: int, s: float) -> float:
        """Return the change of coordinate `axis` for a change of the other one."""
        direction = self.direction(s)
        return float(direction[axis] / direction[1 - axis])

    def distance_mm(self, place_mm: FloatArray) -> float:
        """Return how far a place (a, r) is from the parabola, along the normal."""
        s, f = (place_mm - self.origin_mm) @ self.tangent, (place_mm - self.origin_mm) @ self.normal
        c0, c1, c2 = self.coefficients
        return float(f - (c0 + s * (c1 + s * c2)))

    def _normal_gradient(self, s: float) -> FloatArray:
        """Change of f(s) for motions of all points, shape (N, 2)."""
        hat = np.array([1.0, s, s * s]) @ self.solver
        steepness = self.coefficients[1] + 2.0 * self.along_mm * self.coefficients[2]
        gradient = np.zeros((self.count, 2))
        gradient[self.index] = hat[:, None] * (self.normal - steepness[:, None] * self.tangent)
        return gradient
