"""What a piece that several sensors see at once says of where they stand to each other."""

from collections.abc import Iterator, Sequence

import numpy as np

from measure.piece.gradient import Dimension, gradient_of, told
from measure.piece.rig.laying import LaidOnRig

SHIFT = "shift"
TWIST = "twist"
NOTHING_ALONG = (
    "along its length the piece is everywhere the same: a shift of one sensor that way, or a tilt "
    "of its sheet out of the other's, is not seen; take placings whose lengths point elsewhere "
    "and calibrate the rig on them"
)


def relative_of(laid: LaidOnRig, names: Sequence[str]) -> Iterator[Dimension]:
    """Yield how far each sensor but the first stands off, in the piece's section.

    Shifts along the piece's x and z, and a turn about its length (what half the piece's size is
    off by), told together, so that one does not pass for another; against what all other sensors
    see.

    Parameters
    ----------
    laid
        The points of one shot.
    names
        Of the rig's sensors.
    """
    present = np.unique(laid.sensor)
    arm = 0.5 * laid.piece.size_mm
    for index in present[1:]:
        on = (laid.sensor == index)[:, None]
        moving = np.column_stack([laid.normal, laid.turning_mm / arm])
        columns = np.where(on, moving, 0.0)
        for place, what in enumerate((f"{SHIFT} x", f"{SHIFT} z", TWIST)):
            gradient = gradient_of(columns, np.eye(3)[place], laid)
            if gradient is not None:
                yield told(f"{what} {names[index]}", 0.0, gradient, laid)
