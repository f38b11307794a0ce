"""The radius of a cylinder as the sensor measures it: the paper's Table 5."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray
from calib.judging.arc import points_of_arc
from calib.judging.fitted_arc import FittedArc
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

_FEWEST_POINTS = 40
_SHORTEST_ARC_RAD = np.radians(60.0)
# Of the nominal radius.
_FARTHEST_RADIUS = 0.2
_LARGEST_SCATTER = 0.005
# An axis that is 3 degrees off moves the points of an arc by as much as speckle does.
_WORSE_WITH_AXIS = 1.5
_TWO_SIDED_95 = 1.96


@dataclass(frozen=True, slots=True)
class CylinderReading:
    """One placement of a cylinder.

    Attributes
    ----------
    name
        Name of the picture.
    radius_mm, u95_mm
        The radius and its expanded uncertainty; the sensor's own part is in it. NaN where the
        cylinder could not be measured.
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
    rms_mm: float = float("nan")
    tilt_deg: float = float("nan")
    arc_deg: float = 0.0
    points: int = 0
    reason: str = ""


def judge_cylinder(
    stripe: StripePoints,
    sensor: LaserSensor,
    radius_mm: float,
    *,
    name: str,
    axis_in_cam: FloatArray | None = None,
) -> CylinderReading:
    """Measure the radius of a cylinder from the stripe on it.

    Parameters
    ----------
    stripe
        All ridge points of the picture; those on the cylinder are found by `radius_mm`.
    sensor
        The sensor under test.
    radius_mm
        Nominal radius.
    name
        Name of the picture.
    axis_in_cam
        Shape (3,), direction of the cylinder's axis in the camera frame where the fixture tells
        it; None where it is to be found with the radius.

    Returns
    -------
    CylinderReading
        With a reason where nothing could be measured.

    Notes
    -----
    See `fit_section`. What blurs the stripe draws a bent one inwards by the blur's variance over
    twice the bending radius in the picture; that is taken off. What scatters beyond the points'
    sigma (speckle, the surface) is added to all of them alike. `u95_mm` knows nothing of what
    draws all points of an arc one way, as fading towards its ends does: 0.01 mm in renderings.

    An arc of 150 degrees tells the radius ten times worse while the axis is unknown.
    """
    frame = SheetFrame.of(sensor.plane)
    on_arc, centre = points_of_arc(stripe, sensor, frame, radius_mm)
    arc = stripe.select(on_arc)
    if len(arc) < _FEWEST_POINTS:
        reason = (
            f"{len(arc)} stripe points make a section of radius {radius_mm:g} mm; "
            f"{_FEWEST_POINTS} are needed"
        )
        return CylinderReading(name, points=len(arc), reason=reason)
    slope = None if axis_in_cam is None else frame.slope_of(axis_in_cam)
    fitted = FittedArc.settled(arc, sensor, frame, centre, radius_mm, None)
    reason = ""
    if slope is not None:
        free, fitted = fitted, FittedArc.settled(arc, sensor, frame, centre, radius_mm, slope)
        reason = _contradiction(free, fitted)
    reason = reason or _refusal(fitted, radius_mm)
    if reason:
        return CylinderReading(name, points=len(arc), reason=reason)
    return _reading(fitted, name)


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


def _contradiction(free: FittedArc, held: FittedArc) -> str:
    """Return that the points contradict the axis given; empty where they do not."""
    if held.scatter_mm <= _WORSE_WITH_AXIS * free.scatter_mm:
        return ""
    return (
        f"points scatter by {held.scatter_mm:.3f} mm about a section with this axis, by "
        f"{free.scatter_mm:.3f} mm about the best; the axis is another one"
    )


def _reading(fitted: FittedArc, name: str) -> CylinderReading:
    fit = fitted.fit
    return CylinderReading(
        name,
        radius_mm=fit.radius_mm,
        u95_mm=_TWO_SIDED_95 * fitted.sigma_radius_mm,
        rms_mm=fitted.rms_mm,
        tilt_deg=float(np.degrees(np.arctan(np.linalg.norm(fit.slope)))),
        arc_deg=float(np.degrees(fitted.arc_rad)),
        points=len(fitted.arc),
    )
