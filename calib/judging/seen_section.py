"""How a camera sees the stripe on a cylinder, and where blur draws its centres to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray
from calib.judging.section import SectionFit
from calib.seeing.stripe import kernel_of
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

_STEP_RAD = 0.02
# Brightness along an arc: the cosine of incidence and a laser's smooth unevenness.
_DEGREE = 4
_ROUNDS = 5
_USUAL = 2.0
_FEWEST_CLEAR = 100


@dataclass(frozen=True, slots=True, eq=False)
class SeenSection:
    """The picture of a section, at each of N points of the stripe on it.

    Attributes
    ----------
    arc
        The points as observed.
    outward
        Shape (N, 2), unit, across the section's picture and away from its centre.
    bend_per_px
        Shape (N,), how much it bends inwards: one over the bending radius.
    across, along
        Shape (N,), px/mm: what a step along the cylinder, away from the sheet, moves in the
        picture: outwards, and in the sense of growing angle.
    fading_per_px
        Shape (N,), growth of the logarithm of the sheet's brightness along the stripe.
    """

    arc: StripePoints
    outward: FloatArray
    bend_per_px: FloatArray
    across: FloatArray
    along: FloatArray
    fading_per_px: FloatArray

    @classmethod
    def of(
        cls,
        arc: StripePoints,
        place_mm: FloatArray,
        sensor: LaserSensor,
        frame: SheetFrame,
        fit: SectionFit,
        slope: FloatArray,
    ) -> "SeenSection":
        """See a section.

        Parameters
        ----------
        arc, place_mm
            The stripe's points, and where they lie on the sheet, shape (N, 2).
        sensor, frame
            The sensor.
        fit, slope
            The section, and the slope of the axis that makes it, its sign included.
        """
        angle = angles_around(place_mm, fit.centre_mm)
        before, here, after = (
            sensor.camera.project(frame.points(fit.points_mm(angle + step)))
            for step in (-_STEP_RAD, 0.0, _STEP_RAD)
        )
        half_step = 0.5 * np.linalg.norm(after - before, axis=1)
        tangent = 0.5 * (after - before) / half_step[:, None]
        outward = np.column_stack([tangent[:, 1], -tangent[:, 0]])
        centre = sensor.camera.project(frame.points(fit.centre_mm[None]))
        outward *= np.sign(((here - centre) * outward).sum(axis=1))[:, None]
        bend = -((before - 2.0 * here + after) * outward).sum(axis=1) / half_step**2
        moved = _picture_of_step(frame.points(fit.points_mm(angle)), sensor, frame, slope)
        across = (moved * outward).sum(axis=1)
        light = arc.peak * arc.width_px / np.maximum(np.abs(across), 1e-9)
        return cls(
            arc=arc,
            outward=outward,
            bend_per_px=bend,
            across=across,
            along=(moved * tangent).sum(axis=1),
            fading_per_px=_growth(angle, np.log(light)) * _STEP_RAD / half_step,
        )

    def width_misfit(self) -> float:
        """Return the mean square of what the sheet's slant leaves of the widths, px^4."""
        clear = ~self.arc.saturated
        if not clear.any():
            clear = ~clear
        slant, square = self.across[clear] ** 2, self.arc.width_px[clear] ** 2
        slant = slant - slant.mean()
        share = max(float(slant @ square), 0.0) / max(float(slant @ slant), 1e-12)
        return float(np.var(square - share * slant))

    def lens_variance_px2(self, sheet_mm2: float) -> float:
        """Return the variance of the blur that is not the sheet's thickness."""
        rest = float(np.median(self.arc.width_px**2 - sheet_mm2 * self.across**2))
        return max(rest, 0.0)

    def pull_px(self, sheet_mm2: float) -> tuple[FloatArray, FloatArray]:
        r"""Return how far blur moves the points outwards, shape (N,): by bending, by fading.

        Parameters
        ----------
        sheet_mm2
            Variance of the sheet's thickness, :math:`s^2`.

        Notes
        -----
        The light that makes a point comes from its neighbourhood. Lens and kernel spread it
        alike to all sides, by the variance :math:`b^2`, and draw a stripe of bend
        :math:`\kappa` inwards by :math:`\kappa b^2 / 2`. The sheet's thickness spreads it
        along the cylinder, whose picture has the parts e across and t along the stripe. Where the
        stripe's brightness grows along it as :math:`\exp(\gamma x)`, its ridge is moved by
        :math:`-e\,t\,s^2\gamma`: the light beside the sheet's middle belongs to places of
        another brightness. The thickness also makes a bent stripe's profile skew; of its mean's
        shift, :math:`3 \kappa t^2 s^2 / 2` inwards, the ridge shows the part
        :math:`b^2 / (b^2 + e^2 s^2)`.
        """
        kernel = kernel_of(self.arc.width_px, self.arc.peak)
        even = self.lens_variance_px2(sheet_mm2) + kernel**2
        own = sheet_mm2 * self.across**2
        skew = 1.5 * self.along**2 * sheet_mm2 * even / (even + own)
        by_bending = -self.bend_per_px * (0.5 * even + skew)
        by_fading = -self.across * self.along * sheet_mm2 * self.fading_per_px
        return by_bending, by_fading


def sheet_variance_mm2(sections: Sequence[SeenSection]) -> float:
    """Return the variance of the sheet's thickness that the widths of the stripes tell.

    Where the cylinder is seen along its side the sheet looks thinner; what the widths follow of
    that is the sheet's, what stays is the lens's. Clipped stripes look wider than they are: they
    count only where there are no others.
    """
    clear = [~section.arc.saturated for section in sections]
    if sum(int(c.sum()) for c in clear) < _FEWEST_CLEAR:
        clear = [np.ones(len(section.arc), dtype=bool) for section in sections]
    both = spread = 0.0
    most = np.inf
    for section, keep in zip(sections, clear, strict=True):
        if not keep.any():
            continue
        slant, square = section.across[keep] ** 2, section.arc.width_px[keep] ** 2
        most = min(most, float(np.median(square / np.maximum(slant, 1e-9))))
        both += float((slant - slant.mean()) @ square)
        spread += float(((slant - slant.mean()) ** 2).sum())
    return float(np.clip(both / max(spread, 1e-12), 0.0, most))


def angles_around(place_mm: FloatArray, centre_mm: FloatArray) -> FloatArray:
    """Return angles around a centre, without a jump, from the middle of the points."""
    arm = place_mm - centre_mm
    middle = np.arctan2(*arm.mean(axis=0)[::-1])
    turn = np.array([[np.cos(middle), -np.sin(middle)], [np.sin(middle), np.cos(middle)]])
    turned = arm @ turn
    return np.asarray(middle + np.arctan2(turned[:, 1], turned[:, 0]))


def _picture_of_step(
    points_in_cam_mm: FloatArray, sensor: LaserSensor, frame: SheetFrame, slope: FloatArray
) -> FloatArray:
    """Return d(pixel)/d(distance from the sheet) along the cylinder's axis, px/mm, (N, 2)."""
    upright = np.cross(frame.axes_in_cam[0], frame.axes_in_cam[1])
    half = 0.5 * (upright + slope @ frame.axes_in_cam)
    ahead = sensor.camera.project(points_in_cam_mm + half)
    return np.asarray(ahead - sensor.camera.project(points_in_cam_mm - half))


def _growth(angle: FloatArray, values: FloatArray) -> FloatArray:
    """Return d(values)/d(angle) of a smooth curve through values, robustly, shape (N,)."""
    reach = max(0.5 * float(np.ptp(angle)), 1e-9)
    place = (angle - angle.min()) / reach - 1.0
    terms = np.polynomial.legendre.legvander(place, _DEGREE)
    weight = np.ones(len(values))
    for _ in range(_ROUNDS):
        curve = np.linalg.lstsq(terms * weight[:, None], values * weight, rcond=None)[0]
        off = values - terms @ curve
        usual = max(1.4826 * float(np.median(np.abs(off))), 1e-9)
        weight = 1.0 / np.hypot(1.0, off / (_USUAL * usual))
    slope = np.polynomial.legendre.legder(curve)
    return np.asarray(np.polynomial.legendre.legval(place, slope) / reach)
