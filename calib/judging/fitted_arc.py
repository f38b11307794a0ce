"""A cylinder's section fitted to the stripe on it, with what it owes to points and sensor."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.judging.section import (
    SectionFit,
    distance_gradient,
    fit_section,
    form_of_slope,
    slope_of_form,
)
from calib.judging.seen_section import SeenSection, angles_around
from calib.seeing.stripe import kernel_of
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

_ROUNDS = 3
_FARTHEST_USUAL = 4.0
# Errors a distance r apart along the stripe are correlated by exp(-r^2 / 4 kernel^2): one in
# sqrt(4 pi) kernels of length is independent.
_KERNELS_A_POINT = 3.545
# How well the pulls of blur are known, parts of them: the bend's, of which the sheet's and the
# lens's parts are told apart by the widths; the fading's, whose brightness is read off the peaks.
_PULL_DOUBT = (0.15, 0.25)


@dataclass(frozen=True, slots=True, eq=False)
class ArcOnSheet:
    """The stripe on a cylinder, before a sensor.

    Attributes
    ----------
    arc
        The N points as observed.
    sensor, frame
        Where they lie on the sheet.
    unit_mm
        The nominal radius.
    centre_mm
        Shape (2,), where about the axis meets the sheet.
    """

    arc: StripePoints
    sensor: LaserSensor
    frame: SheetFrame
    unit_mm: float
    centre_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class FittedArc:
    """The stripe on a cylinder and the section through it.

    Attributes
    ----------
    arc
        The points as observed.
    fit
        The section.
    seen
        Its picture.
    slope
        Shape (2,), of the axis; its sign as known, or as the stripe's widths tell.
    usual
        Shape (N,), the points that scatter as the others do.
    arc_rad
        Angle around the centre that the points cover.
    covariance_mm2
        Shape (3, 3), of the form, by the scatter of the points.
    form_by_common
        Shape (3, 15), what the form owes to what all placements share: the parameters of the
        sensor, and one standard deviation each of the pulls by bending and by fading.
    """

    arc: StripePoints
    fit: SectionFit
    seen: SeenSection
    slope: FloatArray
    usual: BoolArray
    arc_rad: float
    covariance_mm2: FloatArray
    form_by_common: FloatArray

    @property
    def rms_mm(self) -> float:
        """Root mean square distance of the usual points from the mantle."""
        return float(np.sqrt(np.mean(self.fit.residual_mm[self.usual] ** 2)))

    @property
    def scatter_mm(self) -> float:
        """Standard deviation of all points from the mantle, by their mean size."""
        return float(np.mean(np.abs(self.fit.residual_mm)) * np.sqrt(np.pi / 2.0))

    @classmethod
    def settled(
        cls, on_sheet: ArcOnSheet, slope: FloatArray | None, sheet_mm2: float | None
    ) -> "FittedArc":
        """Fit, and fit again with the pull of blur and the true scatter known from the last fit.

        Parameters
        ----------
        on_sheet
            Points on the section, mostly.
        slope
            The axis where it is known.
        sheet_mm2
            Variance of the sheet's thickness; None where it is not known yet, and all of the
            stripe's width is taken for the lens's.
        """
        arc, unit_mm = on_sheet.arc, on_sheet.unit_mm
        pixels, centre = arc.centre_px, on_sheet.centre_mm
        form = unit_mm * form_of_slope(np.zeros(2) if slope is None else slope)
        sigma = np.full(len(arc), 0.01 * unit_mm)
        pulls = np.zeros((2, len(arc)))
        for _ in range(_ROUNDS):
            place = on_sheet.frame.coordinates(on_sheet.sensor.locate(pixels))
            fit = fit_section(
                place, sigma, centre, form, unit_mm=unit_mm, axis_known=slope is not None
            )
            seen, leaning = _seen(on_sheet, place, fit, slope)
            pulls = np.stack(seen.pull_px(0.0 if sheet_mm2 is None else sheet_mm2))
            outward = _distance_by_pixel(on_sheet, pixels, place, fit, seen.outward)
            across = _distance_by_pixel(on_sheet, pixels, place, fit, arc.normal)
            extra_px = _extra_scatter_px(fit.residual_mm / across, arc.sigma_px)
            sigma = np.abs(across) * np.hypot(arc.sigma_px, extra_px)
            pixels = arc.centre_px - pulls.sum(axis=0)[:, None] * seen.outward
            centre, form = fit.centre_mm, _kept(fit.form_mm, slope, unit_mm)
        angle = angles_around(place, fit.centre_mm)
        gain = fit.form_by_residual
        doubt = gain @ (np.array(_PULL_DOUBT)[:, None] * pulls * outward).T
        return cls(
            arc=arc,
            fit=fit,
            seen=seen,
            slope=leaning,
            usual=np.abs(fit.residual_mm) <= _FARTHEST_USUAL * sigma,
            arc_rad=float(np.ptp(angle)),
            covariance_mm2=_alike(arc, angle) * ((gain * sigma**2) @ gain.T),
            form_by_common=np.column_stack([_by_sensor(on_sheet, pixels, place, fit), doubt]),
        )


def common_covariance(sensor: LaserSensor) -> FloatArray:
    """Return the covariance, shape (15, 15), of what `FittedArc.form_by_common` goes by."""
    covariance = np.eye(15)
    covariance[:13, :13] = sensor.covariance
    return covariance


def _seen(
    on_sheet: ArcOnSheet, place: FloatArray, fit: SectionFit, slope: FloatArray | None
) -> tuple[SeenSection, FloatArray]:
    """See a section with the axis that is known, or with that of the two that the widths fit."""
    towards = slope_of_form(fit.form_mm)
    axes = [slope] if slope is not None else [towards, -towards]
    both = [
        (SeenSection.of(on_sheet.arc, place, on_sheet.sensor, on_sheet.frame, fit, axis), axis)
        for axis in axes
    ]
    return min(both, key=lambda one: one[0].width_misfit())


def _kept(form: FloatArray, slope: FloatArray | None, unit_mm: float) -> FloatArray:
    return form if slope is None else unit_mm * form_of_slope(slope)


def _distance_by_pixel(
    on_sheet: ArcOnSheet,
    pixels: FloatArray,
    place: FloatArray,
    fit: SectionFit,
    direction: FloatArray,
) -> FloatArray:
    """Return d(distance)/d(shift of the point along a picture direction), mm/px, shape (N,)."""
    by_pixel, _ = on_sheet.sensor.location_jacobians(pixels)
    moved = (by_pixel @ direction[:, :, None])[:, :, 0] @ on_sheet.frame.axes_in_cam.T
    return np.asarray((distance_gradient(place, fit, on_sheet.unit_mm) * moved).sum(axis=1))


def _extra_scatter_px(residual_px: FloatArray, sigma_px: FloatArray) -> float:
    """Return the scatter beyond sigma that explains the residuals, as one figure for all."""
    scatter = float(np.median(np.abs(residual_px))) / 0.6745
    return float(np.sqrt(max(scatter**2 - float(np.median(sigma_px)) ** 2, 0.0)))


def _alike(arc: StripePoints, angle: FloatArray) -> float:
    """Return how many neighbouring points count as one, as they share noise."""
    along = arc.centre_px[np.argsort(angle)]
    length_px = float(np.linalg.norm(np.diff(along, axis=0), axis=1).sum())
    kernel = float(np.median(kernel_of(arc.width_px, arc.peak)))
    return max(1.0, _KERNELS_A_POINT * kernel * len(arc) / length_px)


def _by_sensor(
    on_sheet: ArcOnSheet, pixels: FloatArray, place: FloatArray, fit: SectionFit
) -> FloatArray:
    """Return what the form owes to the sensor's parameters, shape (3, 13)."""
    _, by_sensor = on_sheet.sensor.location_jacobians(pixels)
    on_frame = np.einsum("ij,njk->nik", on_sheet.frame.axes_in_cam, by_sensor)
    gradient = distance_gradient(place, fit, on_sheet.unit_mm)
    return np.asarray(fit.form_by_residual @ np.einsum("ni,nik->nk", gradient, on_frame))
