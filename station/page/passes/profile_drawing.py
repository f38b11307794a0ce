"""A measured profile as the browser draws it: the same geometry as `station.plots`, as paths."""

from collections.abc import Iterator
from functools import cache

import numpy as np

from calib import FloatArray
from measure import ReferenceProfile, ReferenceUnknown, reference_profile
from station.documents import ProfileDocument, WheelDocument
from station.errors import InputUnusable, NotFound
from station.page.passes.paths import path_of
from station.pipeline import load_reference
from station.plots import (
    D_MM,
    H_MM,
    Drawn,
    Gauge,
    gauges_of,
    outline_mm,
    shared_u95,
    tread_wear,
)
from station.store import JsonObject

_MOST_OF_WEAR = 400
"""Points of the wear over the tread: as many as a screen shows."""


def profile_drawing(
    row_id: int, wheel: WheelDocument, reference: ReferenceProfile | None, reference_name: str
) -> JsonObject:
    """Return all that is drawn of a wheel's profile.

    Parameters
    ----------
    row_id
        Of the measurement.
    wheel
        Its row, with the profile.
    reference, reference_name
        What it was measured by; None where that is not to be had any more.

    Raises
    ------
    NotFound
        If it has no profile.
    """
    if wheel.profile is None:
        raise NotFound(f"measurement {row_id} has no profile: {wheel.reason or 'none was kept'}")
    drawn = Drawn.of(wheel, wheel.profile, reference, H_MM[0])
    return {
        "measurement": row_id,
        "window_mm": {"d": D_MM, "h": H_MM},
        "points": len(wheel.profile.d_mm),
        "reference": {
            "name": reference_name,
            "path": None if reference is None else path_of(outline_mm(reference)),
        },
        "sensors": wheel.profile.sensors,
        "strands": list(_strands(drawn, wheel.profile)),
        "names_at": [_alone_at(drawn, place) for place in range(len(wheel.profile.sensors))],
        "band": " ".join(path_of(drawn.band(run), closed=True) for run in drawn.runs()),
        "lost": " ".join(_lost(drawn)),
        "tip_mm": drawn.tip_mm,
        "tape_d_mm": drawn.levels.tape_d_mm,
        "gauges": [_gauge(each) for each in gauges_of(wheel, drawn)],
        "wear": None if reference is None else _wear(wheel, drawn),
    }


def reference_named(name: str, of_station: str) -> ReferenceProfile | None:
    """Return the reference of a name; None where it is neither analytic nor the station's own."""
    try:
        return reference_profile(name)
    except ReferenceUnknown:
        return _own(name, of_station)


def _own(name: str, of_station: str) -> ReferenceProfile | None:
    try:
        own = _loaded(of_station)
    except InputUnusable:  # its file is gone since
        return None
    return own if own.name == name else None


@cache
def _loaded(name: str) -> ReferenceProfile:
    return load_reference(name)


def _strands(drawn: Drawn, profile: ProfileDocument) -> Iterator[JsonObject]:
    """Yield the measured line in pieces, each with the places of the sensors that saw it."""
    for run in drawn.runs():
        for bits, strand in drawn.strands(run):
            seen = [place for place in range(len(profile.sensors)) if bits >> place & 1]
            yield {"seen_by": seen, "path": path_of(drawn.points_mm[strand])}


def _alone_at(drawn: Drawn, place: int) -> list[float] | None:
    """Return the middle of the longest piece that one sensor alone saw; None where there is none.

    Found here: in a browser the length of a path of thousands of points is dear.
    """
    alone = [
        drawn.points_mm[strand]
        for run in drawn.runs()
        for bits, strand in drawn.strands(run)
        if bits == 1 << place
    ]
    longest = max(alone, key=_length_mm, default=None)
    if longest is None:
        return None
    middle: list[float] = np.round(longest[len(longest) // 2], 3).tolist()
    return middle


def _length_mm(points_mm: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(points_mm, axis=0), axis=1).sum())


def _lost(drawn: Drawn) -> Iterator[str]:
    for run in drawn.runs():
        outline = drawn.lost(run)
        if outline is not None:
            yield path_of(outline, closed=True)


def _gauge(gauge: Gauge) -> JsonObject:
    return {
        "quantity": gauge.quantity,
        "ends": gauge.ends,
        "words": gauge.words,
        "words_at": gauge.words_at,
        "anchor": gauge.anchor,
        "down_px": gauge.down_px,
        "levels": gauge.levels,
        "touches": gauge.touches,
    }


def _wear(wheel: WheelDocument, drawn: Drawn) -> JsonObject:
    """Return the wear over the tread; its u95 is the points' own, and what all of them share."""
    points, half_band = tread_wear(drawn)
    every = max(1, -(-len(points) // _MOST_OF_WEAR))
    u95 = np.hypot(half_band, shared_u95(wheel))
    return {
        "d_mm": np.round(points[::every, 0], 2).tolist(),
        "wear_mm": np.round(points[::every, 1], 4).tolist(),
        "u95_mm": np.round(u95[::every], 4).tolist(),
    }
