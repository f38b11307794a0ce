"""The one radius that several sections of a cylinder share, their axes unknown."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.special import log_ndtr, logsumexp

from calib.arrays import FloatArray, frozen

# How far cylinders lean, each way: anything between is equally likely, by its logarithm.
_TILTS_RAD = np.radians(np.geomspace(0.5, 30.0, 9))
_RADII = 41
_DIRECTIONS = 181
_REACH = 6.0
# The window of directions reaches this many of their own sigmas to both sides; a lean of less
# than so many sigmas may have any direction.
_TURN = 10.0
_ROUND = 4.0
_ROUNDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class KnownForm:
    """The form of one section as its points tell it, see `SectionFit`.

    Attributes
    ----------
    form_mm
        Shape (3,).
    covariance_mm2
        Shape (3, 3).
    """

    form_mm: FloatArray
    covariance_mm2: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "form_mm", frozen(self.form_mm, (3,), "form_mm"))
        covariance = frozen(self.covariance_mm2, (3, 3), "covariance_mm2")
        object.__setattr__(self, "covariance_mm2", covariance)

    @property
    def information(self) -> FloatArray:
        """Inverse of the covariance, shape (3, 3)."""
        return np.asarray(np.linalg.inv(self.covariance_mm2))

    def moved(self, by_mm: FloatArray) -> "KnownForm":
        """Return the form that is off by a shift, shape (3,)."""
        return KnownForm(self.form_mm + by_mm, self.covariance_mm2)

    def directions_rad(self) -> FloatArray:
        """Return twice the angles in which the axis may lean, evenly spaced."""
        lean = float(np.hypot(*self.form_mm[1:]))
        sigma = float(np.sqrt(np.linalg.eigvalsh(self.covariance_mm2[1:, 1:])[-1]))
        half = _TURN * sigma / (lean - _ROUND * sigma) if lean > _ROUND * sigma else np.inf
        middle = np.arctan2(self.form_mm[2], self.form_mm[1])
        turn = np.linspace(-1.0, 1.0, _DIRECTIONS)[:-1] * min(half, np.pi)
        return np.asarray(middle + turn)

    def log_likelihood(self, radii_mm: FloatArray, tilt_rad: float) -> FloatArray:
        r"""Return how likely the form is with each radius, the axis leaning as others lean.

        Parameters
        ----------
        radii_mm
            Shape (K,).
        tilt_rad
            Standard deviation of the two slopes of the axis, about square to the sheet.

        Returns
        -------
        log_likelihood
            Shape (K,), up to a constant of the form.

        Notes
        -----
        A radius R and a lean make the form :math:`(R + q, q \cos\chi, q \sin\chi)`: for one
        direction, a straight line. The slope squared is :math:`2w + w^2` with :math:`w = 2q/R`, so
        along the line the normal likelihood times the normal prior is a normal law again, and the
        integral over q > 0 is known; over the direction it is summed.
        """
        chi = self.directions_rad()
        information = self.information
        ray = np.stack([np.ones_like(chi), np.cos(chi), np.sin(chi)], axis=1)
        off = np.outer(radii_mm, [1.0, 0.0, 0.0]) - self.form_mm
        steep = np.einsum("ci,ij,cj->c", ray, information, ray)
        rise = -off @ information @ ray.T
        base = 0.5 * np.einsum("ki,ij,kj->k", off, information, off)
        scale = 1.0 / (radii_mm[:, None] * tilt_rad**2)
        steep = steep + 4.0 * scale / radii_mm[:, None]
        rise = rise - 2.0 * scale
        inside = 0.5 * rise**2 / steep + log_ndtr(rise / np.sqrt(steep)) - 0.5 * np.log(steep)
        total = np.asarray(logsumexp(inside, axis=1)) + np.log(chi[1] - chi[0])
        return np.asarray(total - base - 2.0 * np.log(tilt_rad) - np.log(radii_mm))

    def best_with(self, radius_mm: float) -> FloatArray:
        """Return the most likely form of a cylinder of a radius, shape (3,)."""
        information = self.information
        off = np.array([radius_mm, 0.0, 0.0]) - self.form_mm
        chi = self.directions_rad()
        for _ in range(2):
            ray = np.stack([np.ones_like(chi), np.cos(chi), np.sin(chi)], axis=1)
            steep = np.einsum("ci,ij,cj->c", ray, information, ray)
            lean = np.maximum(-(ray @ information @ off) / steep, 0.0)
            left = off + lean[:, None] * ray
            best = int(np.argmin(np.einsum("ci,ij,cj->c", left, information, left)))
            step = chi[1] - chi[0]
            found = self.form_mm + left[best]
            chi = chi[best] + np.linspace(-step, step, _DIRECTIONS)
        return np.asarray(found)


@dataclass(frozen=True, slots=True)
class SharedRadius:
    """A radius and what is known of it.

    Attributes
    ----------
    radius_mm
        Its mean.
    half_mm
        Half of the interval that holds 95 %.
    tilt_rad
        How far the axes lean, each way: the most likely standard deviation.
    """

    radius_mm: float
    half_mm: float
    tilt_rad: float

    @classmethod
    def of(cls, forms: Sequence[KnownForm]) -> Self:
        """Find the radius that several forms share, each with an axis of its own.

        Parameters
        ----------
        forms
            At least one.

        Notes
        -----
        The axes lean at random about square to the sheet, by a standard deviation that is found
        from all of them together with the radius (a hierarchical model, all else integrated
        out). The most likely section of a single placement would not do: of a section that is
        nearly round, noise makes an ellipse, whose minor semi-axis is too small.
        """
        free = np.array([form.form_mm[0] - np.hypot(*form.form_mm[1:]) for form in forms])
        sigma = np.array([_sigma_of_radius(form) for form in forms])
        low, high = float((free - _REACH * sigma).min()), float((free + _REACH * sigma).max())
        for _ in range(_ROUNDS):
            radii = np.linspace(max(low, 1e-3), high, _RADII)
            likely = np.array([
                sum(form.log_likelihood(radii, tilt) for form in forms) for tilt in _TILTS_RAD
            ])
            by_radius = np.exp(logsumexp(likely, axis=0) - logsumexp(likely))
            mean = float(by_radius @ radii)
            spread = float(np.sqrt(by_radius @ (radii - mean) ** 2))
            reach = _REACH * max(spread, 0.5 * (radii[1] - radii[0]))
            low, high = mean - reach, mean + reach
        tilt = _TILTS_RAD[int(np.argmax(logsumexp(likely, axis=1)))]
        return cls(mean, _half_interval(radii, by_radius), float(tilt))

    def by_shift(self, forms: Sequence[KnownForm], shifts_mm: Sequence[FloatArray]) -> float:
        """Return what the radius changes by when the forms are shifted, the tilt held."""
        reach = 2.0 * _REACH * self.half_mm / 1.96
        radii = np.linspace(self.radius_mm - reach, self.radius_mm + reach, _RADII)

        def mean(moved: Sequence[KnownForm]) -> float:
            likely = sum(form.log_likelihood(radii, self.tilt_rad) for form in moved)
            weight = np.exp(likely - logsumexp(likely))
            return float(weight @ radii)

        moved = [form.moved(shift) for form, shift in zip(forms, shifts_mm, strict=True)]
        back = [form.moved(-shift) for form, shift in zip(forms, shifts_mm, strict=True)]
        return 0.5 * (mean(moved) - mean(back))


def _sigma_of_radius(form: KnownForm) -> float:
    """Return the standard deviation of the minor semi-axis alone."""
    lean = max(float(np.hypot(*form.form_mm[1:])), 1e-9)
    by_form = np.array([1.0, -form.form_mm[1] / lean, -form.form_mm[2] / lean])
    return float(np.sqrt(by_form @ form.covariance_mm2 @ by_form))


def _half_interval(radii_mm: FloatArray, weight: FloatArray) -> float:
    """Return half of the middle 95 % of a law given at evenly spaced places."""
    below = np.cumsum(weight) - 0.5 * weight
    low, high = np.interp([0.025, 0.975], below, radii_mm)
    return float(0.5 * (high - low))
