"""From the sections of a cylinder to its radius, by what is known of its axes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from calib.arrays import FloatArray
from calib.judging.fitted_arc import FittedArc, common_covariance
from calib.judging.section import form_of_slope, radius_of_form, slope_of_form
from calib.judging.shared_radius import KnownForm, SharedRadius
from calib.sensor import LaserSensor

_TWO_SIDED_95 = 1.96
_BY_CHANCE = 1e-3


@dataclass(frozen=True, slots=True)
class Radius:
    """A radius, its expanded uncertainty, and the tilt of the axis it was read with."""

    radius_mm: float
    u95_mm: float
    tilt_deg: float


def on_known_axis(
    fitted: Sequence[FittedArc], sensor: LaserSensor, slope: FloatArray
) -> tuple[Radius, list[Radius]]:
    """Return the radius by all sections and by each, fitted with the axis held."""
    shape = form_of_slope(slope)
    per_radius = shape / (shape @ shape)
    radii = np.array([arc.fit.radius_mm for arc in fitted])
    variance = np.array([per_radius @ arc.covariance_mm2 @ per_radius for arc in fitted])
    by_common = np.array([per_radius @ arc.form_by_common for arc in fitted])
    common = common_covariance(sensor)
    tilt = _tilt_deg(slope)
    each = [
        Radius(float(radius), _u95(own + shared @ common @ shared), tilt)
        for radius, own, shared in zip(radii, variance, by_common, strict=True)
    ]
    weight = (1.0 / variance) / (1.0 / variance).sum()
    together = weight @ by_common
    u95 = _u95(float(weight**2 @ variance + together @ common @ together))
    return Radius(float(weight @ radii), u95, tilt), each


def in_common(fitted: Sequence[FittedArc], sensor: LaserSensor) -> tuple[Radius, list[Radius]]:
    """Return the radius that all sections share, and by each with the axis that fits it best."""
    forms = [KnownForm(arc.fit.form_mm, arc.covariance_mm2) for arc in fitted]
    shared = _shared(forms, [arc.form_by_common for arc in fitted], sensor)
    each = [_with_best_axis(form, shared) for form in forms]
    return shared, each


def alone(fitted: FittedArc, sensor: LaserSensor) -> Radius:
    """Return the radius by one section."""
    form = KnownForm(fitted.fit.form_mm, fitted.covariance_mm2)
    return _shared([form], [fitted.form_by_common], sensor)


def on_one_axis(
    fitted: Sequence[FittedArc], sensor: LaserSensor
) -> tuple[Radius, list[Radius], str]:
    """Return the radius by all sections and by each, all of one form; or why they are not."""
    forms = [KnownForm(arc.fit.form_mm, arc.covariance_mm2) for arc in fitted]
    information = np.array([form.information for form in forms])
    covariance = np.asarray(np.linalg.inv(information.sum(axis=0)), dtype=np.float64)
    share = covariance @ information
    form_mm = np.array([form.form_mm for form in forms])
    mean = np.einsum("nij,nj->i", share, form_mm)
    square = float(np.einsum("ni,nij,nj->", form_mm - mean, information, form_mm - mean))
    freedom = 3 * (len(forms) - 1)
    if freedom and square > chdtri(freedom, _BY_CHANCE):
        reason = (
            f"the sections differ by chi-square {square:.0f} of {freedom} from one axis for all; "
            "let each have its own"
        )
        return Radius(float("nan"), float("nan"), float("nan")), [], reason
    by_common = (share @ np.array([arc.form_by_common for arc in fitted])).sum(axis=0)
    shared = _shared([KnownForm(mean, covariance)], [by_common], sensor)
    best = KnownForm(mean, covariance).best_with(shared.radius_mm)
    shape = best / radius_of_form(best)
    return shared, [_with_shape(form, shape, shared) for form in forms], ""


def _shared(
    forms: Sequence[KnownForm], by_common: Sequence[FloatArray], sensor: LaserSensor
) -> Radius:
    shared = SharedRadius.of(forms)
    variance = 0.0
    for step in _root_of(common_covariance(sensor)).T:
        shifts = [by @ step for by in by_common]
        if max(float(np.abs(shift).max()) for shift in shifts) > 1e-3 * shared.half_mm:
            variance += shared.by_shift(forms, shifts) ** 2
    u95 = float(np.hypot(shared.half_mm, _TWO_SIDED_95 * np.sqrt(variance)))
    return Radius(shared.radius_mm, u95, float(np.degrees(np.arctan(shared.tilt_rad))))


def _root_of(covariance: FloatArray) -> FloatArray:
    """Return a matrix whose square, by its transpose, is the covariance."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(values.clip(min=0.0)))


def _with_best_axis(form: KnownForm, shared: Radius) -> Radius:
    best = form.best_with(shared.radius_mm)
    lean = max(float(np.hypot(*best[1:])), 1e-12)
    # With the radius held, the form may turn and lean: it moves along these two.
    free = np.array([[best[1] / lean, 1.0, 0.0], [best[2] / lean, 0.0, 1.0]]).T
    return _with_shape(form, best / radius_of_form(best), shared, free)


def _with_shape(
    form: KnownForm, shape: FloatArray, shared: Radius, free: FloatArray | None = None
) -> Radius:
    """Return the radius of one section, its shape held as the shared radius makes it.

    The doubt of the shared radius is in it whole, for the shape takes it up; the section's own
    scatter with what the shape, `free` to move along these columns, leaves of it.
    """
    information = form.information
    by_form = information @ shape / (shape @ information @ shape)
    keep = np.eye(3)
    if free is not None:
        keep = keep - free @ np.linalg.solve(free.T @ information @ free, free.T @ information)
    by_point = by_form @ keep
    u95 = float(np.hypot(shared.u95_mm, _u95(float(by_point @ form.covariance_mm2 @ by_point))))
    return Radius(float(by_form @ form.form_mm), u95, _tilt_deg(slope_of_form(shape)))


def _u95(variance: float) -> float:
    return float(_TWO_SIDED_95 * np.sqrt(variance))


def _tilt_deg(slope: FloatArray) -> float:
    return float(np.degrees(np.arctan(np.linalg.norm(slope))))
