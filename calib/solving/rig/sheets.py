"""Which stripe points a solve begins with: those on a line, in the plane of most lines."""

from collections.abc import Sequence

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.errors import Degenerate
from calib.solving.rig.seen import SeenView
from calib.solving.start import start_plane

# Two lines lie in some plane nearly always; a third tells.
_FEWEST_STRIPES = 3


def points_on_sheets(views: Sequence[SeenView]) -> dict[tuple[str, str], BoolArray]:
    """Tell which stripe points of each picture lie on its line and, with it, on a sheet.

    The sheet is the one that most lines of the sensor agree on, not the one it was calibrated to
    have: where a sensor was bent since, its stripes are true all the same.

    Returns
    -------
    on_sheet
        By showing and sensor, shape (N,); pictures without a stripe have none.
    """
    found: dict[tuple[str, str], BoolArray] = {}
    for name in dict.fromkeys(view.sensor for view in views):
        lines = {
            view.showing: view.line
            for view in views
            if view.sensor == name and view.line is not None
        }
        ends = np.array([line.ends_mm for line in lines.values()]).reshape(-1, 2, 3)
        for (showing, line), agrees in zip(lines.items(), _in_one_plane(ends), strict=True):
            found[showing, name] = line.agreeing & agrees
    return found


def _in_one_plane(ends_mm: FloatArray) -> BoolArray:
    everyone = np.ones(len(ends_mm), dtype=bool)
    if len(ends_mm) < _FEWEST_STRIPES:
        return everyone
    try:
        return start_plane(ends_mm, np.zeros((len(ends_mm), 3, 3))).agreeing
    except Degenerate:
        # All on one line in space: no sheet is singled out, and none of them is false for that.
        return everyone
