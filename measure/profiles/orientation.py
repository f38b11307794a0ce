"""Which way a profile lies in a table: what is up, where the flange back is, what comes first."""

from enum import Enum

import numpy as np

from calib import FloatArray
from measure.errors import ProfileTextInvalid
from measure.profile import Profile

_MIN_ROWS = 20
_MIN_FLANGE_MM = 14.0
_TIP_FROM_BACK_MM = (4.0, 40.0)
_TAPE_D_MM = 70.0
# The flange tip is farther from either side than this.
_CLEAR_MM = 3.0
# Rows in the order of the profile make its shortest way; shuffled ones a far longer one.
_SHUFFLED = 1.5
_CENTRE_BELOW_MM = 5.0


class Origin(Enum):
    """What a table's lateral places count from."""

    BACK = "the flange back"
    TAPE = "the tape circle"
    UNSAID = "unsaid"


def oriented(table_mm: FloatArray, origin: Origin = Origin.UNSAID) -> Profile:
    """Turn rows of (lateral, height) to run from the flange back to the field side, height up.

    Parameters
    ----------
    table_mm
        Shape (N, 2), in any order, either sign of either column.
    origin
        What the lateral places count from. Where it is unsaid, the place of the flange tip tells:
        it lies 4 to 40 mm from the flange back.

    Raises
    ------
    ProfileTextInvalid
        If there are too few rows, or no flange in them. Half a wheel is let pass: what it lacks
        the gauges say.

    Notes
    -----
    The flange tip is the one extreme height clear of both sides; the other, foot of the back face
    or of the chamfer, is at a side. The side nearer to the tip is the back.
    """
    if len(table_mm) < _MIN_ROWS:
        raise ProfileTextInvalid(f"{len(table_mm)} rows; {_MIN_ROWS} or more are needed")
    relief = float(np.ptp(table_mm[:, 1]))
    if not relief >= _MIN_FLANGE_MM:
        raise ProfileTextInvalid(
            f"no flange: heights differ by {relief:.1f} mm; {_MIN_FLANGE_MM:.0f} or more are "
            "needed (inches want a header that says so: Units=inch)"
        )
    x, h = _in_order(table_mm).T
    h = h * _upward(x, h)
    tip = int(np.argmax(h))
    first, last = abs(x[0] - x[tip]), abs(x[-1] - x[tip])
    if first > last:
        x, h, tip = x[::-1], h[::-1], len(x) - 1 - tip
    if x[-1] < x[tip]:
        x = -x
    d = x + _shift(float(x[tip]), origin)
    beyond = d > d[tip]
    fall = float(h[tip] - h[beyond].min()) if beyond.any() else 0.0
    if not (fall >= _MIN_FLANGE_MM and d.max() >= d[tip] + _MIN_FLANGE_MM):
        raise ProfileTextInvalid(
            f"no flange: from the highest place, {d[tip]:.1f} mm from the back, it falls by "
            f"{fall:.1f} mm up to {d.max():.1f}; {_MIN_FLANGE_MM:.0f} or more are needed"
        )
    return Profile(d, h, np.zeros(len(d)))


def _in_order(table_mm: FloatArray) -> FloatArray:
    """Return the rows in the order of the profile, from one end or the other."""
    up = table_mm * [1.0, _upward(*table_mm.T)]
    # Seen from deep below the flange a wheel's profile never turns back, its steep sides included.
    tip_x = up[np.argmax(up[:, 1]), 0]
    sideways = np.sign(np.median(up[:, 0]) - tip_x) or 1.0
    centre = np.array([tip_x, up[:, 1].min() - _CENTRE_BELOW_MM])
    angle = np.arctan2(up[:, 1] - centre[1], (up[:, 0] - centre[0]) * sideways)
    sorted_rows = table_mm[np.argsort(-angle, kind="stable")]
    if _length(table_mm) <= _SHUFFLED * _length(sorted_rows):
        return table_mm
    return sorted_rows


def _upward(x_mm: FloatArray, h_mm: FloatArray) -> float:
    """Return the sign that turns the flange tip, an extreme clear of the sides, upwards."""
    middle = float(np.median(h_mm))
    inside = (x_mm > x_mm.min() + _CLEAR_MM) & (x_mm < x_mm.max() - _CLEAR_MM)

    def inner_reach(sign: float) -> float:
        peak = int(np.argmax(sign * h_mm))
        return sign * (float(h_mm[peak]) - middle) if inside[peak] else 0.0

    up, down = inner_reach(1.0), inner_reach(-1.0)
    if up == down:  # Cut off beside the tip: what reaches farther from the tread is the flange.
        up, down = h_mm.max() - middle, middle - h_mm.min()
    return 1.0 if up >= down else -1.0


def _shift(tip_x_mm: float, origin: Origin) -> float:
    """Return what to add to lateral places to count them from the flange back."""
    low, high = _TIP_FROM_BACK_MM
    shifts = {Origin.BACK: (0.0,), Origin.TAPE: (_TAPE_D_MM,), Origin.UNSAID: (0.0, _TAPE_D_MM)}
    for shift in shifts[origin]:
        if low <= tip_x_mm + shift <= high:
            return shift
    raise ProfileTextInvalid(
        f"the highest place is at {tip_x_mm:.1f} mm; a flange tip is {low:.0f} to {high:.0f} from "
        f"the flange back, {low - _TAPE_D_MM:.0f} to {high - _TAPE_D_MM:.0f} from the tape circle"
    )


def _length(points_mm: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(points_mm, axis=0), axis=1).sum())
