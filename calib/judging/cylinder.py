"""The radius of a cylinder as the sensor measures it: the paper's Table 5."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from calib.arrays import FloatArray
from calib.judging.arc import points_of_arc
from calib.judging.cylinder_radius import Radius, alone, in_common, on_known_axis, on_one_axis
from calib.judging.fitted_arc import ArcOnSheet, FittedArc
from calib.judging.seen_section import sheet_variance_mm2
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

_FEWEST_POINTS = 40
_SHORTEST_ARC_RAD = np.radians(60.0)
# Of the nominal radius.
_FARTHEST_RADIUS = 0.2
_LARGEST_SCATTER = 0.005
_NO_SCATTER = 1e-4
# An axis that is 3 degrees off moves the points of an arc by as much as speckle does.
_WORSE_WITH_AXIS = 1.5

Axes = Literal["own", "one", "known"]
"""How the placements' axes are: each its own, one for all, or known to the caller."""


@dataclass(frozen=True, slots=True)
class CylinderReading:
    """One placement of a cylinder.

    Attributes
    ----------
    name
        Name of the picture.
    radius_mm, u95_mm
        The radius and its expanded uncertainty; the sensor's own part is in it. Where the axis is
        not known it is read with the axis that fits the radius of all placements best. NaN where
        the cylinder could not be measured.
    alone_mm, alone_u95_mm
        The same by this picture alone.
    rms_mm
        Root mean square distance of the points from the mantle.
    tilt_deg
        Of the axis, from square to the sheet.
    arc_deg, points
        How much of the section is seen, and in how many points.
    reason
        Why there is no reading; empty where there is one.
    """

    name: str
    radius_mm: float = float("nan")
    u95_mm: float = float("nan")
    alone_mm: float = float("nan")
    alone_u95_mm: float = float("nan")
    rms_mm: float = float("nan")
    tilt_deg: float = float("nan")
    arc_deg: float = 0.0
    points: int = 0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class CylinderJudgement:
    """One cylinder in several placements.

    Attributes
    ----------
    readings
        One for every picture, in order.
    radius_mm, u95_mm
        The radius by all placements together and its expanded uncertainty; NaN where there is
        no reading.
    axes
        What was held of the axes.
    """

    readings: tuple[CylinderReading, ...]
    radius_mm: float
    u95_mm: float
    axes: Axes


def judge_cylinders(
    stripes: Sequence[tuple[str, StripePoints]],
    sensor: LaserSensor,
    radius_mm: float,
    *,
    axis_in_cam: FloatArray | None = None,
    one_axis: bool = False,
) -> CylinderJudgement:
    """Measure the radius of one cylinder from the stripes on it in several placements.

    Parameters
    ----------
    stripes
        Name, and all ridge points, of each picture; those on the cylinder are found by
        `radius_mm`.
    sensor
        The sensor under test.
    radius_mm
        Nominal radius.
    axis_in_cam
        Shape (3,), direction of the cylinder's axis in the camera frame where the fixture tells
        it; None where it is to be found with the radius.
    one_axis
        The cylinder was shifted but not turned between the pictures: its axis, not known, is the
        same in all.

    Returns
    -------
    CylinderJudgement
        Readings carry a reason where nothing could be measured.

    Notes
    -----
    Of a picture alone, an arc of 150 degrees hardly tells the radius while the axis is unknown: a
    tilt, a shift and a smaller radius together look alike, and the bound of Cramer and Rao is ten
    times that with the axis known. Several placements of one cylinder share the radius, see
    `SharedRadius`. Whether they share the axis cannot be told from the sections where tilts are
    small, and to assume it wrongly makes the radius too large: it is for the caller to say. What
    says it wrongly and shows is refused, by chi-square.

    What blurs the stripe is taken off, see `SeenSection.pull_px`. What scatters beyond the points'
    sigma (speckle, the surface) is added to all of them alike.
    """
    frame = SheetFrame.of(sensor.plane)
    slope = None if axis_in_cam is None else frame.slope_of(axis_in_cam)
    found = [_find(name, stripe, sensor, frame, radius_mm) for name, stripe in stripes]
    first = [FittedArc.settled(one, None, None) for one in found if isinstance(one, ArcOnSheet)]
    sheet_mm2 = sheet_variance_mm2([arc.seen for arc in first]) if first else 0.0
    fitted: list[FittedArc] = []
    readings: list[CylinderReading] = []
    for (name, _), one in zip(stripes, found, strict=True):
        if isinstance(one, CylinderReading):
            readings.append(one)
            continue
        arc, reason = _settle(one, slope, sheet_mm2)
        readings.append(_reading(arc, name, reason))
        fitted += [] if reason else [arc]
    read = [place for place, reading in enumerate(readings) if not reading.reason]
    return _judgement(readings, read, fitted, sensor, slope, one_axis=one_axis)


def judge_cylinder(
    stripe: StripePoints,
    sensor: LaserSensor,
    radius_mm: float,
    *,
    name: str,
    axis_in_cam: FloatArray | None = None,
) -> CylinderReading:
    """Measure the radius of a cylinder from one picture alone; see `judge_cylinders`."""
    return judge_cylinders([(name, stripe)], sensor, radius_mm, axis_in_cam=axis_in_cam).readings[0]


def _find(
    name: str, stripe: StripePoints, sensor: LaserSensor, frame: SheetFrame, radius_mm: float
) -> ArcOnSheet | CylinderReading:
    """Return the points on the section, or why there is no reading."""
    on_arc, centre = points_of_arc(stripe, sensor, frame, radius_mm)
    arc = stripe.select(on_arc)
    if len(arc) >= _FEWEST_POINTS:
        return ArcOnSheet(arc, sensor, frame, radius_mm, centre)
    reason = (
        f"{len(arc)} stripe points make a section of radius {radius_mm:g} mm; "
        f"{_FEWEST_POINTS} are needed"
    )
    return CylinderReading(name, points=len(arc), reason=reason)


def _settle(
    on_sheet: ArcOnSheet, slope: FloatArray | None, sheet_mm2: float
) -> tuple[FittedArc, str]:
    """Return the section and why it is none; empty where it is one."""
    fitted, reason = FittedArc.settled(on_sheet, None, sheet_mm2), ""
    if slope is not None:
        free, fitted = fitted, FittedArc.settled(on_sheet, slope, sheet_mm2)
        reason = _contradiction(free, fitted, on_sheet.unit_mm)
    return fitted, reason or _refusal(fitted, on_sheet.unit_mm)


def _refusal(fitted: FittedArc, radius_mm: float) -> str:
    """Return why points are no section of the cylinder; empty where they are."""
    found_mm = fitted.fit.radius_mm
    if not fitted.arc_rad >= _SHORTEST_ARC_RAD:
        return f"{np.degrees(fitted.arc_rad):.0f} degrees of the section are seen; 60 are needed"
    if not abs(found_mm - radius_mm) <= _FARTHEST_RADIUS * radius_mm:
        return f"the section's radius is {found_mm:.2f} mm; is it this cylinder?"
    if not fitted.scatter_mm <= _LARGEST_SCATTER * radius_mm:
        return f"points scatter by {fitted.scatter_mm:.2f} mm about a section; is there a cylinder?"
    return ""


def _contradiction(free: FittedArc, held: FittedArc, radius_mm: float) -> str:
    """Return that the points contradict the axis given; empty where they do not."""
    least_mm = max(free.scatter_mm, _NO_SCATTER * radius_mm)
    if held.scatter_mm <= _WORSE_WITH_AXIS * least_mm:
        return ""
    return (
        f"points scatter by {held.scatter_mm:.3f} mm about a section with this axis, by "
        f"{free.scatter_mm:.3f} mm about the best; the axis is another one"
    )


def _reading(fitted: FittedArc, name: str, reason: str) -> CylinderReading:
    """Return a reading without its radius."""
    if reason:
        return CylinderReading(name, points=len(fitted.arc), reason=reason)
    return CylinderReading(
        name,
        rms_mm=fitted.rms_mm,
        arc_deg=float(np.degrees(fitted.arc_rad)),
        points=len(fitted.arc),
    )


def _judgement(
    readings: list[CylinderReading],
    read: list[int],
    fitted: list[FittedArc],
    sensor: LaserSensor,
    slope: FloatArray | None,
    *,
    one_axis: bool,
) -> CylinderJudgement:
    """Put the radii into the readings, by what is held of the axes."""
    axes: Axes = "known" if slope is not None else "one" if one_axis else "own"
    none = CylinderJudgement(tuple(readings), float("nan"), float("nan"), axes)
    if not fitted:
        return none
    by_itself: list[Radius]
    if slope is not None:
        shared, each = on_known_axis(fitted, sensor, slope)
        by_itself = each
    elif one_axis:
        shared, each, reason = on_one_axis(fitted, sensor)
        if reason:
            return replace(none, readings=_all_refused(readings, reason))
        by_itself = [alone(one, sensor) for one in fitted]
    else:
        by_itself = [alone(one, sensor) for one in fitted]
        shared, each = in_common(fitted, sensor)
    for place, common, own in zip(read, each, by_itself, strict=True):
        readings[place] = replace(
            readings[place],
            radius_mm=common.radius_mm,
            u95_mm=common.u95_mm,
            alone_mm=own.radius_mm,
            alone_u95_mm=own.u95_mm,
            tilt_deg=common.tilt_deg,
        )
    return CylinderJudgement(tuple(readings), shared.radius_mm, shared.u95_mm, axes)


def _all_refused(readings: list[CylinderReading], reason: str) -> tuple[CylinderReading, ...]:
    return tuple(
        reading if reading.reason else CylinderReading(reading.name, reason=reason)
        for reading in readings
    )
