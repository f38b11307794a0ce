"""The references that standards give as arcs, lines and polynomials."""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from measure.errors import ReferenceUnknown
from measure.reference import ReferenceProfile
from measure.segments import Arc, Line, Polynomial, Segment

# EN 13715, flange height 28 mm, thickness 32.5 mm.
_S1002: tuple[Segment, ...] = (
    Arc(-62.764705882, (-49.5, 9.519259302), 20.5, 1),
    Arc(-49.662510381, (-55.0, 16.0), 12.0, 1),
    Arc(-39.764473993, (-58.558326413, 8.834924130), 20.0, 1),
    Line(-38.426669071, (0.0, -93.576667419), -2.747477419),
    Arc(-35.0, (-26.210665, 16.446), 13.0, -1),
    Polynomial(
        -26.0,
        (
            -4320.221063,
            -1038.384026,
            -106.5501873,
            -6.051367875,
            -0.2054332446,
            -4.169739389e-3,
            -4.687195829e-5,
            -2.252755540e-7,
        ),
    ),
    Polynomial(
        32.15796,
        (
            0.0,
            -3.358537058e-2,
            1.565681624e-3,
            -2.810427944e-5,
            5.844240864e-8,
            -1.562379023e-8,
            5.309217349e-15,
            -5.957839843e-12,
            2.646656573e-13,
        ),
    ),
    Line(60.0, (0.0, 1.364323640), -0.066666667),
)

# China, high speed.
_LMA: tuple[Segment, ...] = (
    Arc(-62.307692, (-45.0, 6.619168), 25.0, 1),
    Arc(-52.557372, (-54.0, 16.0), 12.0, 1),
    Arc(-40.265268, (-54.360658, 13.021757), 15.0, 1),
    Line(-38.053345, (-39.0, 14.675765), -float(np.tan(np.radians(70.0)))),
    Arc(-28.4709, (-24.897649, 16.863134), 14.0, -1),
    Arc(-10.75, (-5.5, 90.346), 90.0, -1),
    Arc(4.253514, (15.5, 449.732976), 450.0, -1),
    Line(30.0, (10.0, -0.2701267), -1.0 / 40.0),
    Line(60.0, (30.0, -0.7701267), -1.0 / 15.0),
    Line(65.0, (60.0, -2.7701267), -1.0),
)

_ANALYTIC: Mapping[str, tuple[Segment, ...]] = {"S1002": _S1002, "LMA": _LMA}


@lru_cache
def reference_profile(name: str) -> ReferenceProfile:
    """Return the reference profile of a name: ``S1002`` or ``LMA``.

    Raises
    ------
    ReferenceUnknown
        If there is none of that name.

    Examples
    --------
    >>> from measure import Quantity
    >>> nominal = reference_profile("LMA").nominal
    >>> round(nominal[Quantity.FLANGE_THICKNESS_12], 3)
    31.974
    """
    if name not in _ANALYTIC:
        known = ", ".join(_ANALYTIC)
        raise ReferenceUnknown(f"reference {name!r} is not known; give one of {known}, or a file")
    return ReferenceProfile.from_segments(name, _ANALYTIC[name])
