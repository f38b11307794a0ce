"""One picture of one wheel: from its stripe to readings, or the reason why there are none."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib import Cause, FloatArray, LaserSensor, StripePoints
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.gauges import Gauged, gauge
from measure.gauging.uncertainty import Budget, Motions, whitened
from measure.laying.by_axle import Laid, Unmeasured, lay_by_axle
from measure.laying.by_shape import lay_by_shape
from measure.laying.section import SheetPoints
from measure.mounting import Mounting
from measure.placing.pieces import MIN_PIECE, pieces, sizes
from measure.placing.registration import see_back_face
from measure.placing.template import Template, template_of
from measure.quantities import ASSUMED_BACK_SIGMA_MM, NEEDS_BACK, Quantity, Status
from measure.reference import BACK_Y_MM, ReferenceProfile

MIN_STRIPE_POINTS = 100
"""A picture with fewer points on its stripe shows no wheel."""
WINDOW_MM = 3.0
"""Half-width of the pieces of profile that are smoothed."""
_BACK_STEP_MM = 0.1
# How much of the correction for the bend of a stripe may be wrong: on rendered wheels none of it is
# left on the tip, four tenths where the face runs out into the throat, a half on a sharp worn edge.
_BEND_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Value:
    """One quantity from one picture: mm, what is not known of it, how it was come by."""

    value_mm: float
    budget: Budget
    status: Status


@dataclass(frozen=True, slots=True, eq=False)
class FrameReadings:
    """What one picture says of a wheel.

    Attributes
    ----------
    values
        The quantities that could be read.
    curve
        The points they were read off.
    back_mm, tip_mm
        Lateral and vertical datum in the curve.
    laid
        How the stripe was laid over the reference.
    coverage
        Share of the reference, from tip to field side, that was seen.
    wear_max_at_d_mm
        Where the greatest tread wear is.
    """

    values: Mapping[Quantity, Value]
    curve: Curve
    back_mm: float
    tip_mm: float
    laid: Laid
    coverage: float
    wear_max_at_d_mm: float | None


def measure_frame(
    stripe: StripePoints,
    sensor: LaserSensor,
    reference: ReferenceProfile,
    mounting: Mounting | None,
    *,
    assume_back: bool,
) -> FrameReadings | Unmeasured:
    """Read the gauges off the stripe of one picture."""
    # Specks go first: in bad light there are more of them than points of the wheel.
    hanging = stripe.select(sizes(pieces(stripe.centre_px, stripe.normal)) >= MIN_PIECE)
    if len(hanging) < MIN_STRIPE_POINTS:
        return Unmeasured(
            f"no stripe: {len(hanging)} of {len(stripe)} points hang together, "
            f"{MIN_STRIPE_POINTS} needed; look at exposure and laser"
        )
    template = template_of(reference)
    sheet = SheetPoints.of(hanging, sensor)
    if mounting is not None:
        laid = lay_by_axle(sheet, sensor, mounting, template)
    else:
        laid = lay_by_shape(sheet, sensor, template)
    if isinstance(laid, Unmeasured):
        return laid
    specks = len(stripe) - len(hanging)
    if specks:
        stray = laid.left_out.get(Cause.STRAY_LIGHT, 0) + specks
        laid = replace(laid, left_out={**laid.left_out, Cause.STRAY_LIGHT: stray})
    return _read(laid, sensor, reference, template, assume_back=assume_back)


def _read(
    laid: Laid,
    sensor: LaserSensor,
    reference: ReferenceProfile,
    template: Template,
    *,
    assume_back: bool,
) -> FrameReadings | Unmeasured:
    section = laid.section
    sigma = laid.noise.counting_mm
    curve = Curve(section.points_mm, laid.along_mm, sigma, WINDOW_MM)
    back = _back(laid, sigma, template)
    gauged = gauge(curve, back, reference)
    if gauged is None:
        return Unmeasured("half a wheel: no flange tip is seen; it is the datum of all readings")
    if not gauged.found:
        return Unmeasured("half a wheel: the tread at the tape circle is not seen")
    budgets = _budgets(gauged, _motions(laid, sensor))
    if back.status is not Status.OK:
        budgets = _with_assumed_back(budgets, gauged, curve, back, reference)
    refused = () if back.status is Status.OK or assume_back else NEEDS_BACK
    values = {
        quantity: Value(found.estimate.value, budgets[quantity], _status(found, laid))
        for quantity, found in gauged.found.items()
        if quantity not in refused
    }
    return FrameReadings(
        values=values,
        curve=curve,
        back_mm=back.estimate.value,
        tip_mm=gauged.tip_mm,
        laid=laid,
        coverage=_coverage(laid.along_mm, template),
        wear_max_at_d_mm=gauged.wear_max_at_d_mm,
    )


def _back(laid: Laid, sigma_mm: FloatArray, template: Template) -> Found:
    """Return the flange back as seen, or where the shape of the flange says it must be."""
    points = laid.section.points_mm
    seen = see_back_face(points, sigma_mm, laid.shift_mm, template)
    if seen is not None:
        return Found(Estimate(seen.a_mm, seen.gradient), Status.OK)
    assumed = float(laid.shift_mm[0]) + BACK_Y_MM
    return Found(Estimate.exact(assumed, len(points)), Status.REFERENCE_ASSUMED)


def _status(found: Found, laid: Laid) -> Status:
    return Status.REFERENCE_ASSUMED if laid.axle_offset_mm is None else found.status


def _motions(laid: Laid, sensor: LaserSensor) -> Motions:
    section = laid.section
    by_sensor = whitened(section.jacobian @ laid.sheet.by_sensor, sensor.covariance)
    bend = section.jacobian @ laid.sheet.bend_mm[:, :, None] * _BEND_SHARE
    return Motions(
        own_mm=section.own_mm * (laid.noise.counting_mm / section.sigma_mm)[:, None],
        once_mm=laid.once_mm,
        shared_mm=np.concatenate([by_sensor, laid.shared_mm, bend], axis=2),
    )


def _budgets(gauged: Gauged, motions: Motions) -> dict[Quantity, Budget]:
    return {
        quantity: motions.budget(found.estimate, found.blind_mm)
        for quantity, found in gauged.found.items()
    }


def _with_assumed_back(
    budgets: Mapping[Quantity, Budget],
    gauged: Gauged,
    curve: Curve,
    back: Found,
    reference: ReferenceProfile,
) -> dict[Quantity, Budget]:
    """Add what an assumed flange back may be off, by its effect on each reading."""
    moved = gauge(curve, Found(back.estimate + _BACK_STEP_MM, back.status), reference)
    budgets = dict(budgets)
    for quantity, budget in budgets.items():
        after = moved.found.get(quantity) if moved is not None else None
        change = after.estimate.value - gauged.found[quantity].estimate.value if after else 0.0
        off = change / _BACK_STEP_MM * ASSUMED_BACK_SIGMA_MM
        budgets[quantity] = Budget(budget.single_mm, np.append(budget.shared_mm, off))
    return budgets


def _coverage(along_mm: FloatArray, template: Template) -> float:
    """Share of the millimetres from the tip to the field side that hold a point."""
    start, end = template.along_mm[template.tip], template.along_mm[-1]
    seen = np.unique(np.floor(along_mm[(along_mm >= start) & (along_mm < end)] - start))
    return float(min(1.0, len(seen) / np.floor(end - start)))
