"""Which points and pieces of a stripe can be the wheel, where the reference is taken to lie."""

import numpy as np

from calib import BoolArray, FloatArray, IntArray
from measure.placing.template import Template

# A wheel wears inward; it lies outward where its profile is another than the reference: flanges
# of one railway are thicker by 4 mm than those of another, and metal that rolls over makes a lip.
_OUTSIDE_MM = (-14.0, 6.0)
# With the tip laid on the tip, no tread stands that far out: the next profile's is 1 mm higher.
_TREAD_OUTSIDE_MM = 3.0
_BEYOND_END_MM = 1.0
# What lies under the reference's last point is the field face of the rim.
_UNDER_END_MM = 3.0
_MIN_SHARE = 0.5


def can_be_wheel(
    along_mm: FloatArray, outside_mm: FloatArray, nearest: IntArray, template: Template
) -> BoolArray:
    """Tell which points, as `Template.place` gives them, lie where a worn wheel may be.

    Back and tip of the flange do not wear: what lies far behind them is something else.
    """
    low, high = _OUTSIDE_MM
    on_profile = along_mm < template.along_mm[-1] + _BEYOND_END_MM
    on_profile &= (nearest < len(template) - 1) | (outside_mm > -_UNDER_END_MM)
    unworn = (nearest < template.back_count) | template.is_unworn(along_mm)
    floor = np.where(unworn, -high, low)
    ceiling = np.where(template.is_tread(nearest), _TREAD_OUTSIDE_MM, high)
    return np.asarray((outside_mm > floor) & (outside_mm < ceiling) & on_profile)


def mostly_wheel(
    inside: BoolArray, along_mm: FloatArray, piece: IntArray, template: Template
) -> BoolArray:
    """Tell which points belong to pieces of stripe that are wheel for the greater part.

    A piece that hangs together was drawn by one light on one thing: of a reflection that touches
    the wheel's place the rest tells what it is. What lies beyond the ends of the reference (web,
    field face) speaks for neither.

    Parameters
    ----------
    inside, along_mm, piece
        Shape (N,): whether a point can be wheel, its place, the number of its piece.
    template
        The reference.
    """
    if len(piece) == 0:
        return np.zeros(0, dtype=bool)
    told = (along_mm > 0.0) & (along_mm < template.along_mm[-1])
    asked = np.bincount(piece, told)
    yes = np.bincount(piece, told & inside)
    return np.asarray((yes >= _MIN_SHARE * asked)[piece])
