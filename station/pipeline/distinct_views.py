"""Each picture counts once and has a name of its own, whichever files it comes from."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from calib import View

_ALIKE_DECIMALS = 2
"""Two pictures of one pose differ by their noise, some hundredths of a pixel in some of many
numbers; the points of a file differ from those of its picture by a millionth."""


def named_apart(files: Iterable[tuple[str, Sequence[View]]], taken: Sequence[str]) -> list[View]:
    """Return the views of points files, renamed where another file or a picture has the name.

    Parameters
    ----------
    files
        The name of each file, and its views.
    taken
        Names that pictures have.
    """
    labelled = [(label, view) for label, views in files for view in views]
    times = Counter([*taken, *(view.name for _, view in labelled)])
    return [
        replace(view, name=f"{label}:{view.name}") if times[view.name] > 1 else view
        for label, view in labelled
    ]


def without_copies(views: Sequence[View]) -> tuple[list[View], list[tuple[str, str]]]:
    """Return the views of different pictures, and (name, reason) of the copies left out.

    The same picture again tells nothing new, but counted twice would promise more certainty.
    """
    first: dict[bytes, View] = {}
    copies = []
    for view in views:
        original = first.setdefault(_print_of(view), view)
        if original is not view:
            copies.append((view.name, f"a copy of {original.name}: the same points"))
    return list(first.values()), copies


def _print_of(view: View) -> bytes:
    points = view.points
    if len(points) == 0:
        return view.name.encode()
    order = np.lexsort((points.col, points.row))
    # Adding zero turns -0.0, whose bytes differ, into 0.0.
    seen = np.round(points.centre_px[order], _ALIKE_DECIMALS) + 0.0
    return points.row[order].tobytes() + points.col[order].tobytes() + seen.tobytes()
