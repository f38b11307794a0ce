"""The diameter of a wheel, where the sheets of a rig tell it, and nowhere else."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import IntArray
from measure.gauging.uncertainty import COVERAGE_FACTOR
from measure.limits import Limits
from measure.mounting import Survey
from measure.place import WheelPlace
from measure.quantities import Quantity, Reading, Status
from measure.wheelset.agreement import Residuals, agreeing
from measure.wheelset.rolling import (
    SIGMA_BOUNCE_MM,
    RollingCircle,
    Sections,
    fit_rolling_circle,
)

LEAST_SHARE = 0.9
"""So much of what is known of the radius must come from the pictures, not from the survey."""
MOST_U95_MM = 1.0
"""A diameter less sure than this serves nobody: depots measure to some tenths."""
FEWEST_SECTIONS = 3
"""Of two that contradict each other nothing tells which is right."""


@dataclass(frozen=True, slots=True)
class Diameter:
    """The diameter of one wheel at the tape circle.

    Attributes
    ----------
    value_mm, u95_mm
        The diameter and the half-width of its 95 % interval; None where it is not given.
    status
        ``ok`` or ``missing``.
    sections
        Shots that tell it.
    share
        Part of the information on the radius that the pictures hold; the rest is the survey's.
    reason
        Why there is no value, and what would help; None where there is one.
    """

    value_mm: float | None
    u95_mm: float | None
    status: Status
    sections: int
    share: float
    reason: str | None = None

    def __post_init__(self) -> None:
        missing = self.status is Status.MISSING
        absent = self.value_mm is None, self.u95_mm is None, self.reason is not None
        if set(absent) != {missing}:
            raise ValueError(f"it has value and u95, or is missing with a reason; got {self!r}")

    @classmethod
    def missing(cls, reason: str, sections: int = 0, share: float = 0.0) -> "Diameter":
        """Make the diameter that cannot be given."""
        return cls(None, None, Status.MISSING, sections, share, reason)

    def reading(self, limits: Limits) -> Reading:
        """Return it as a reading beside the others of the wheel."""
        if self.value_mm is None or self.u95_mm is None:
            return Reading.missing()
        alarm = limits.judge(Quantity.DIAMETER, self.value_mm, self.u95_mm)
        return Reading(self.value_mm, self.u95_mm, self.status, alarm)


def wheel_diameter(
    places: Sequence[WheelPlace],
    survey: Survey,
    *,
    sigma_bounce_mm: float = SIGMA_BOUNCE_MM,
    least_share: float = LEAST_SHARE,
    most_u95_mm: float = MOST_U95_MM,
) -> Diameter:
    r"""Return the diameter of a wheel that rolled past a rig.

    Parameters
    ----------
    places
        Where it stood, shot by shot. A shot with one sheet tells where the axle was and nothing
        of the radius.
    survey
        What is known of the wheels beforehand; the height over the rail counts most.
    sigma_bounce_mm
        By how much that height changes from one shot of a wheel to another.
    least_share
        Part of the information on the radius that the pictures must hold.
    most_u95_mm
        A diameter less sure than this is not given.

    Returns
    -------
    Diameter
        Missing, with the reason, where the geometry does not support it, or sections contradict
        each other. The survey's radius never pulls the value: it only decides whether there is one.

    Notes
    -----
    Standard deviation of the radius, mm. Sheets meet the wheel so many degrees below the axle,
    ahead (+) or behind (-), and are placed to 0.02 mm and 0.1 mrad against each other; 0.05 mm of
    bounce, 0.5 mrad of the rail's slope; M shots over a way of ±25 or ±60 mm. A point has 0.02 mm
    of noise, or 0.21 mm where sensors vibrate by 0.3 mm against each other:

    ======================  ======  ======  ======  ======  ======  ======  ======
    height known to, mm     1       1       1       1       1       0.1     1
    noise, mm               0.02    0.02    0.02    0.02    0.02    0.02    0.21
    M                       1       3       5       10      10      10      10
    way, mm                 0       ±25     ±60     ±25     ±60     ±60     ±60
    ======================  ======  ======  ======  ======  ======  ======  ======
    +30; or +30, +30        > 9.9   > 9.9   > 9.9   > 9.9   > 9.9   > 9.9   > 9.9
    +22.5, +37.5            1.99    1.65    1.04    1.44    0.90    0.26    2.03
    +15, +45                2.04    1.37    0.76    1.12    0.67    0.22    1.83
    +7.5, +52.5             2.13    1.21    0.65    0.96    0.57    0.22    1.62
    +30, -30                1.00    1.00    1.00    1.00    0.99    0.10    1.00
    +20, -20                0.52    0.52    0.52    0.52    0.52    0.06    0.53
    +10, -10                0.21    0.21    0.21    0.21    0.21    0.03    0.22
    +15, -45                1.07    0.59    0.32    0.47    0.28    0.10    0.75
    +15, +35, +60           0.41    0.31    0.26    0.27    0.24    0.18    0.90
    +20, +60, -20           0.03    0.02    0.02    0.02    0.02    0.02    0.09
    ======================  ======  ======  ======  ======  ======  ======  ======

    The u95 of the diameter is 3.9 times as much. One sheet tells nothing, nor do two in one plane:
    the survey's 10 mm stand. Sheets on one side tell the radius by how their angle changes while
    the wheel rolls by, and want the height known to a tenth; sheets ahead of the axle and behind
    it want to be level with it; with a third below the height is told along with the radius.
    """
    telling = [place for place in places if len(place.treads) > 1]
    if len(telling) < FEWEST_SECTIONS:
        return Diameter.missing(
            f"{len(telling)} of {len(places)} shots show the tread by two sheets or more, "
            f"{FEWEST_SECTIONS} needed: one sheet tells where the axle is, not how large the wheel",
            len(telling),
        )

    def fitted(some: IntArray, *, nominal: bool = False) -> RollingCircle | None:
        chosen = Sections.of([telling[each] for each in some])
        return fit_rolling_circle(chosen, survey, sigma_bounce_mm=sigma_bounce_mm, nominal=nominal)

    def residuals_of(some: IntArray) -> Residuals | None:
        circle = fitted(some)
        return None if circle is None else circle.residuals

    guided = fitted(np.arange(len(telling)), nominal=True)
    share = 0.0 if guided is None else 1.0 - (guided.sigma_mm / survey.sigma_radius_mm) ** 2
    if guided is None or share < least_share:
        return Diameter.missing(_unsupported(guided, share, survey), len(telling), share)
    kept = agreeing(len(telling), residuals_of, fewest=FEWEST_SECTIONS)
    circle = None if kept is None else fitted(kept)
    if kept is None or circle is None:
        reason = (
            f"{len(telling)} sections of the wheel do not lie on one circle that rolls, and "
            "nothing tells which is wrong; look for vibration, and check the rig in the field"
        )
        return Diameter.missing(reason, len(telling), share)
    u95_mm = COVERAGE_FACTOR * 2.0 * circle.sigma_mm
    if not u95_mm <= most_u95_mm:
        return Diameter.missing(_unsure(circle, u95_mm, most_u95_mm, survey), len(kept), share)
    return Diameter(2.0 * circle.radius_mm, u95_mm, Status.OK, len(kept), share)


def _unsupported(circle: RollingCircle | None, share: float, survey: Survey) -> str:
    if circle is None:
        return "the sections of the wheel lie on no circle near its nominal radius"
    return (
        f"the sheets meet the wheel {np.degrees(circle.apart_rad):.0f} degrees apart, and tell "
        f"{100.0 * share:.0f} % of what is known of its radius (survey: "
        f"{survey.sigma_radius_mm:g} mm); sheets ahead of the axle and behind it would tell it"
    )


def _unsure(circle: RollingCircle, u95_mm: float, most_mm: float, survey: Survey) -> str:
    known = f"the diameter is known to {u95_mm:.2f} mm, {most_mm:g} is asked for; "
    if circle.by_height_mm**2 > 0.5 * circle.sigma_mm**2:
        return known + (
            f"the tread's height over the rail is known to {survey.sigma_height_mm:g} mm by the "
            "survey; sheets ahead of the axle, behind it and below it need none"
        )
    return known + (
        f"sheets farther apart around the wheel than {np.degrees(circle.apart_rad):.0f} degrees, "
        "or more shots over a longer way, would tell it"
    )
