"""About which axes a target was turned between showings: a target of two boards needs two."""

from collections.abc import Sequence

import numpy as np

from calib.arrays import FloatArray
from calib.errors import Degenerate, TooFewViews
from calib.solving.rig.closed_form import FEWEST_SHOWINGS, Numbered, turns_between
from calib.solving.rig.links import Link, names_of
from calib.solving.rig.seen import SeenView

# Turns smaller than this, or than so many times what noise makes of none, are none.
_LEAST_TURN_RAD = 0.01
_TURN_OVER_NOISE = 5.0


def require_turns(link: Link, first: Numbered, views: Sequence[SeenView]) -> None:
    """Refuse showings between which a target of two boards was not turned about two axes.

    Its boards' mutual pose is not known: only what turns moves the one camera's board otherwise
    than the other's. Of a target that is only shifted, the shift between the cameras is open along
    all axes; of one turned about one axis alone, along this.

    Raises
    ------
    TooFewViews
        If there are fewer than three showings.
    Degenerate
        If the target was only shifted between them, or turned about one axis alone.
    """
    count = len(first.rotation)
    if count < FEWEST_SHOWINGS:
        raise TooFewViews(
            f"{count} showings to {names_of(link)} together, of two boards; at least "
            f"{FEWEST_SHOWINGS} are needed, the target turned otherwise in each"
        )
    turns = turns_between(first)
    _, values, axes = np.linalg.svd(turns, full_matrices=False)
    spread = values / np.sqrt(len(turns))
    noise = float(np.median([views[row].sigma_rad for row, _ in link.pairs]))
    least = max(_LEAST_TURN_RAD, _TURN_OVER_NOISE * noise)
    if not spread[0] > least:
        raise Degenerate(
            f"the target was shifted but not turned between the showings to {names_of(link)} "
            f"({np.degrees(spread[0]):.2g} degrees): the shift between the two cameras is open "
            "along every axis; turn the target by 20 degrees and more, about two axes"
        )
    if not spread[1] > least:
        raise Degenerate(
            f"between the showings to {names_of(link)} the target was turned about one axis alone, "
            f"{axis_text(axes[0])} in the frame of camera {link.first[0]!r}: the shift between the "
            "two cameras along this axis is open; turn the target about another axis as well, by "
            "20 degrees and more"
        )


def axis_text(axis: FloatArray) -> str:
    """Return a direction in words: its components, the largest one positive."""
    axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
    return f"({axis[0]:.2f}, {axis[1]:.2f}, {axis[2]:.2f})"
