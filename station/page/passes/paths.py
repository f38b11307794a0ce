"""Points in mm as SVG paths in whole micrometres: short, and exact beyond any zoom."""

import numpy as np

from calib import FloatArray

_UM = 1000.0


def path_of(points_mm: FloatArray, *, closed: bool = False) -> str:
    """Return points (d, h), shape (N, 2), as a path; heights go up, so their sign is turned.

    >>> path_of(np.array([[1.0, 2.0], [1.5, 2.0], [1.5, 1.25]]))
    'M1000,-2000l500,0 0,750'
    """
    if not len(points_mm):
        return ""
    places = np.rint(points_mm * [_UM, -_UM]).astype(np.int64)
    # Steps between places that are rounded already: no error adds up along the path.
    steps = " ".join(f"{right},{down}" for right, down in np.diff(places, axis=0).tolist())
    start = f"M{places[0, 0]},{places[0, 1]}"
    return start + (f"l{steps}" if steps else "") + ("z" if closed else "")
