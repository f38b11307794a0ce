"""A cylinder fitted to the stripe on it, with what its radius owes to points and sensor."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.judging.section import (
    SectionFit,
    distance_gradient,
    first_guesses,
    fit_section,
)
from calib.seeing.stripe import kernel_of
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

_ROUNDS = 3
_STEP_RAD = 0.02
_FARTHEST_USUAL = 4.0
# Errors a distance r apart along the stripe are correlated by exp(-r^2 / 4 kernel^2): one in
# sqrt(4 pi) kernels of length is independent.
_KERNELS_A_POINT = 3.545
# Standard deviation of what is anywhere between 0 and 1, held at its middle.
_HALF_UNIFORM = 0.5 / 3.0**0.5


@dataclass(frozen=True, slots=True, eq=False)
class FittedArc:
    """The stripe on a cylinder and the cylinder through it.

    Attributes
    ----------
    arc
        The N points as observed.
    fit
        The section.
    usual
        Shape (N,), the points that scatter as the others do.
    arc_rad
        Angle around the centre that the points cover.
    sigma_radius_mm
        Standard deviation of the radius: scatter of the points and doubt of the sensor.
    """

    arc: StripePoints
    fit: SectionFit
    usual: BoolArray
    arc_rad: float
    sigma_radius_mm: float

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
        cls,
        arc: StripePoints,
        sensor: LaserSensor,
        frame: SheetFrame,
        centre_mm: FloatArray,
        radius_mm: float,
        slope: FloatArray | None,
    ) -> "FittedArc":
        """Fit, and fit again with the bend's pull and the true scatter known from the last fit.

        A bent stripe is drawn inwards by the variance of the kernel it is located with, and by
        that of the lens's blur. How much of the stripe's own width the lens made is not known:
        half is taken, and the doubt is in `sigma_radius_mm`.

        Parameters
        ----------
        arc
            Points on the section, mostly.
        sensor, frame
            Where they lie on the sheet.
        centre_mm, radius_mm
            A first guess.
        slope
            The axis where it is known, see `fit_section`.
        """
        pixels, kernel = arc.centre_px, kernel_of(arc.width_px)
        starts = first_guesses(centre_mm, radius_mm)
        if slope is not None:
            starts = [np.concatenate([centre_mm, [radius_mm], slope])]
        sigma = np.full(len(arc), 0.01 * radius_mm)
        for _ in range(_ROUNDS):
            place = frame.coordinates(sensor.locate(pixels))
            fit = fit_section(place, sigma, starts, axis_known=slope is not None)
            gradient = _residual_by_pixel(arc, pixels, place, sensor, frame, fit)
            extra_px = _extra_scatter_px(fit.residual_mm / gradient, arc.sigma_px)
            sigma = np.abs(gradient) * np.hypot(arc.sigma_px, extra_px)
            starts = [fit.unknowns]
            outward = _outward_per_px2(place, sensor, frame, fit)
            pixels = arc.centre_px + (kernel**2 + 0.5 * arc.width_px**2)[:, None] * outward
        angle = _angles(place, fit)
        unsure = gradient * (outward * arc.normal).sum(axis=1) * arc.width_px**2 * _HALF_UNIFORM
        by_point = fit.radius_by_residual
        variance = (
            _alike(arc, angle) * ((by_point * sigma) ** 2).sum()
            + (by_point @ unsure) ** 2
            + _by_sensor(pixels, place, sensor, frame, fit)
        )
        return cls(
            arc=arc,
            fit=fit,
            usual=np.abs(fit.residual_mm) <= _FARTHEST_USUAL * sigma,
            arc_rad=float(np.ptp(angle)),
            sigma_radius_mm=float(np.sqrt(variance)),
        )


def _residual_by_pixel(
    arc: StripePoints,
    pixels: FloatArray,
    place: FloatArray,
    sensor: LaserSensor,
    frame: SheetFrame,
    fit: SectionFit,
) -> FloatArray:
    """Return d(distance)/d(shift of the point across the stripe), mm/px, shape (N,)."""
    by_pixel, _ = sensor.location_jacobians(pixels)
    across = (by_pixel @ arc.normal[:, :, None])[:, :, 0] @ frame.axes_in_cam.T
    return np.asarray((distance_gradient(place, fit) * across).sum(axis=1))


def _extra_scatter_px(residual_px: FloatArray, sigma_px: FloatArray) -> float:
    """Return the scatter beyond sigma that explains the residuals, as one figure for all."""
    scatter = float(np.median(np.abs(residual_px))) / 0.6745
    return float(np.sqrt(max(scatter**2 - float(np.median(sigma_px)) ** 2, 0.0)))


def _angles(place: FloatArray, fit: SectionFit) -> FloatArray:
    """Return angles around the centre, without a jump, from the middle of the points."""
    arm = place - fit.centre_mm
    middle = np.arctan2(*arm.mean(axis=0)[::-1])
    turn = np.array([[np.cos(middle), -np.sin(middle)], [np.sin(middle), np.cos(middle)]])
    turned = arm @ turn
    return np.asarray(middle + np.arctan2(turned[:, 1], turned[:, 0]))


def _outward_per_px2(
    place: FloatArray, sensor: LaserSensor, frame: SheetFrame, fit: SectionFit
) -> FloatArray:
    """Return half the curvature of the section's picture, outwards, 1/px, shape (N, 2).

    A blur of a bent line draws its centre inwards by half the curvature times its variance.
    """
    angle = _angles(place, fit)
    before, here, after = (
        sensor.camera.project(frame.points(fit.points_mm(angle + step)))
        for step in (-_STEP_RAD, 0.0, _STEP_RAD)
    )
    half_step = 0.5 * np.linalg.norm(after - before, axis=1)
    # Second difference over step squared: towards the inside, as long as the curvature.
    return np.asarray(-0.5 * (before - 2.0 * here + after) / half_step[:, None] ** 2)


def _alike(arc: StripePoints, angle: FloatArray) -> float:
    """Return how many neighbouring points count as one, as they share noise."""
    along = arc.centre_px[np.argsort(angle)]
    length_px = float(np.linalg.norm(np.diff(along, axis=0), axis=1).sum())
    kernel = float(np.median(kernel_of(arc.width_px)))
    return max(1.0, _KERNELS_A_POINT * kernel * len(arc) / length_px)


def _by_sensor(
    pixels: FloatArray, place: FloatArray, sensor: LaserSensor, frame: SheetFrame, fit: SectionFit
) -> float:
    """Return the variance of the radius by the sensor's own doubt, mm^2."""
    _, by_sensor = sensor.location_jacobians(pixels)
    on_frame = np.einsum("ij,njk->nik", frame.axes_in_cam, by_sensor)
    by_distance = np.einsum("ni,nik->nk", distance_gradient(place, fit), on_frame)
    by_parameter = fit.radius_by_residual @ by_distance
    return float(by_parameter @ sensor.covariance @ by_parameter)
