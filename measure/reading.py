"""One shot of one wheel: from its stripes to readings, or the reason why there are none."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from calib import Cause, FloatArray, Rig
from measure.gauging.curve import Curve, Found
from measure.gauging.estimate import Estimate
from measure.gauging.gauges import Gauged, gauge
from measure.gauging.uncertainty import Budget, Motions
from measure.laying.by_axle import Laying, Unmeasured, lay_by_axle
from measure.laying.by_shape import lay_by_shape
from measure.laying.section import SheetPoints
from measure.merging.merged import Merged, merge
from measure.mounting import Survey
from measure.place import WheelPlace
from measure.placing.pieces import MIN_PIECE, pieces, sizes
from measure.placing.registration import see_back_face
from measure.placing.template import Template, template_of
from measure.quantities import ASSUMED_BACK_SIGMA_MM, NEEDS_BACK, Quantity, Status
from measure.reference import BACK_Y_MM, ReferenceProfile
from measure.shot import MIN_STRIPE_POINTS, Shot
from measure.standing import place_of

WINDOW_MM = 3.0
"""Half-width of the pieces of profile that are smoothed."""
_BACK_STEP_MM = 0.1


@dataclass(frozen=True, slots=True)
class Value:
    """One quantity from one shot: mm, what is not known of it, how it was come by."""

    value_mm: float
    budget: Budget
    status: Status


@dataclass(frozen=True, slots=True, eq=False)
class ShotReadings:
    """What one shot says of a wheel.

    Attributes
    ----------
    values
        The quantities that could be read.
    curve
        The points they were read off.
    back_mm, tip_mm
        Lateral and vertical datum in the curve.
    merged
        How the stripes were laid over the reference, and what each sensor contributes.
    coverage
        Share of the reference, from tip to field side, that was seen.
    wear_max_at_d_mm
        Where the greatest tread wear is.
    place
        Where the wheel stood.
    """

    values: Mapping[Quantity, Value]
    curve: Curve
    back_mm: float
    tip_mm: float
    merged: Merged
    coverage: float
    wear_max_at_d_mm: float | None
    place: WheelPlace


def read_shot(
    shot: Shot,
    rig: Rig,
    survey: Survey | None,
    reference: ReferenceProfile,
    *,
    assume_back: bool,
) -> ShotReadings | Unmeasured:
    """Read the gauges off the stripes of one shot; without a survey, off that of one sensor."""
    template = template_of(reference)
    sheets, silent, specks = _sheets(shot, rig)
    while sheets:
        if survey is not None:
            laying = lay_by_axle(sheets, rig, survey, template)
        else:
            ((name, sheet),) = sheets.items()
            laying = lay_by_shape(sheet, rig[name], template)
        if isinstance(laying, Unmeasured):
            return laying
        laying = _with_specks(Laying(laying.parts, {**silent, **laying.silent}), specks)
        merged = merge(laying, rig, survey, template)
        if isinstance(merged, Merged):
            return _read(shot, merged, rig, survey, reference, template, assume_back=assume_back)
        # Once more without them: they had a part in the axle.
        silent |= merged.reasons
        sheets = {name: sheet for name, sheet in sheets.items() if name not in merged.reasons}
    fullest = max(shot.frames, key=lambda frame: len(frame.stripe))
    return Unmeasured(silent[fullest.sensor])


def _sheets(shot: Shot, rig: Rig) -> tuple[dict[str, SheetPoints], dict[str, str], dict[str, int]]:
    """Return the points of each sensor on its sheet, why some have none, and specks left out."""
    sheets, specks = dict[str, SheetPoints](), dict[str, int]()
    silent = {name: "no frame" for name in rig.names if shot.of(name) is None}
    for frame in shot.frames:
        stripe = frame.stripe
        # Specks go first: in bad light there are more of them than points of the wheel.
        hanging = stripe.select(sizes(pieces(stripe.centre_px, stripe.normal)) >= MIN_PIECE)
        if len(hanging) < MIN_STRIPE_POINTS:
            silent[frame.sensor] = (
                f"no stripe: {len(hanging)} of {len(stripe)} points hang together, "
                f"{MIN_STRIPE_POINTS} needed; look at exposure and laser"
            )
            continue
        sheets[frame.sensor] = SheetPoints.of(hanging, rig[frame.sensor].sensor)
        specks[frame.sensor] = len(stripe) - len(hanging)
    return sheets, silent, specks


def _with_specks(laying: Laying, specks: Mapping[str, int]) -> Laying:
    """Count the specks that went first among what was left out."""
    parts = []
    for part in laying.parts:
        count = part.left_out.get(Cause.STRAY_LIGHT, 0) + specks[part.sensor.name]
        counted = {**part.left_out, Cause.STRAY_LIGHT: count} if count else part.left_out
        parts.append(replace(part, left_out=counted))
    return Laying(tuple(parts), laying.silent)


def _read(
    shot: Shot,
    merged: Merged,
    rig: Rig,
    survey: Survey | None,
    reference: ReferenceProfile,
    template: Template,
    *,
    assume_back: bool,
) -> ShotReadings | Unmeasured:
    curve = Curve(merged.points_mm, merged.along_mm, merged.sigma_mm, WINDOW_MM)
    back = _back(merged, template)
    gauged = gauge(curve, back, reference)
    if gauged is None:
        return Unmeasured("half a wheel: no flange tip is seen; it is the datum of all readings")
    if not gauged.found:
        return Unmeasured("half a wheel: the tread at the tape circle is not seen")
    budgets = _budgets(gauged, merged.motions)
    if back.status is not Status.OK:
        budgets = _with_assumed_back(budgets, gauged, curve, back, reference)
    refused = () if back.status is Status.OK or assume_back else NEEDS_BACK
    values = {
        quantity: Value(found.estimate.value, budgets[quantity], _status(found, merged))
        for quantity, found in gauged.found.items()
        if quantity not in refused
    }
    return ShotReadings(
        values=values,
        curve=curve,
        back_mm=back.estimate.value,
        tip_mm=gauged.tip_mm,
        merged=merged,
        coverage=_coverage(merged.along_mm, template),
        wear_max_at_d_mm=gauged.wear_max_at_d_mm,
        place=place_of(shot.time_ns, merged, back, rig, survey),
    )


def _back(merged: Merged, template: Template) -> Found:
    """Return the flange back as seen, or where the shape of the flange says it must be."""
    points = merged.points_mm
    seen = see_back_face(points, merged.sigma_mm, merged.shift_mm, template)
    if seen is not None:
        return Found(Estimate(seen.a_mm, seen.gradient), Status.OK)
    assumed = float(merged.shift_mm[0]) + BACK_Y_MM
    return Found(Estimate.exact(assumed, len(points)), Status.REFERENCE_ASSUMED)


def _status(found: Found, merged: Merged) -> Status:
    return Status.REFERENCE_ASSUMED if merged.first.axle_offset_mm is None else found.status


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
