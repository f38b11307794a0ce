"""Doubles joined, and both sides of an axle paired, by time."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from calib import FloatArray
from measure.train.tracks import Crossing, SeenWheel, Sighting, Track

DOUBLE_SHARE = 0.15
"""Groups nearer than this part of a short gap between axles are one axle: a sensor sees a wheel
over 0.2 m of way at most, and axles stand 1.5 m apart and more."""
CLEAR_RATIO = 3.0
"""Gaps within doubled axles and gaps between axles are told apart where they differ so much."""
PAIR_SHARE = 0.2
"""Two sides are paired within this part of the shortest distance of axles around."""
APART_SHARE = 0.45
"""Sensors of one pass stand less than this part of the smallest distance of axles apart."""
LAG_VOTES = 3
"""How many times as many wheels must say that sensors stand apart as say that they do not."""
LONE_S = 0.25
"""How far apart the two sides of a train of one axle may be seen."""
_NEIGHBOURS = 8


def join_doubles(
    place: int,
    tracks: Sequence[Track],
    *,
    axles: Sequence[int] | None = None,
    counted: int | None = None,
) -> tuple[Sighting, ...]:
    """Join groups of frames that are one axle: a lost or dark frame parts a slow wheel in two.

    Parameters
    ----------
    place
        Of the track whose groups are joined.
    tracks
        All that the sensors of the pass saw.
    axles
        The axle of each of its wheels, where the numbers of triggers tell it.
    counted
        Axles that the controller counted. Of more groups than that the nearest are joined, if
        they are far nearer than all others. Otherwise those are joined that are far too near for
        two axles beside what the sensors saw around; where none saw three, nothing tells.
    """
    wheels = tracks[place].wheels
    gaps = _gaps(tracks[place])
    if axles is not None:
        same = [one == after for one, after in pairwise(axles)]
    else:
        same = _surplus(gaps, counted) or [
            bool(gap < DOUBLE_SHARE * _short_gap(tracks, wheel.time_s))
            for gap, wheel in zip(gaps, wheels, strict=False)
        ]
    joined: list[list[SeenWheel]] = []
    for at, wheel in enumerate(wheels):
        if at and same[at - 1]:
            joined[-1].append(wheel)
        else:
            joined.append([wheel])
    told = {} if axles is None else dict(zip(wheels, axles, strict=True))
    return tuple(Sighting(place, tuple(group), told.get(group[0])) for group in joined)


def _gaps(track: Track) -> FloatArray:
    return np.diff([wheel.time_s for wheel in track.wheels])


def _short_gap(tracks: Sequence[Track], time_s: float) -> float:
    """Return what is a short gap between axles around a time; 0 where nothing is known.

    The lower quartile, as within bogies are half of the gaps of most trains, of the sensor that
    saw the axles most densely: another may have missed many.
    """
    found = []
    for track in tracks:
        gaps = _gaps(track)
        if len(gaps) > 1:
            at = int(np.searchsorted([wheel.time_s for wheel in track.wheels], time_s))
            around = gaps[max(0, at - _NEIGHBOURS) : at + _NEIGHBOURS + 1]
            found.append(float(np.quantile(around, 0.25)))
    return min(found, default=0.0)


def _surplus(gaps: FloatArray, counted: int | None) -> list[bool] | None:
    """Tell which gaps make more groups of the counted axles; None where they are not clear."""
    surplus = 0 if counted is None else len(gaps) + 1 - counted
    if not 0 < surplus < len(gaps):
        return None
    ordered = np.sort(gaps)
    if not ordered[surplus] > CLEAR_RATIO * ordered[surplus - 1]:
        return None
    return [bool(gap <= ordered[surplus - 1]) for gap in gaps]


def pair(tracks: Sequence[Sequence[Sighting]]) -> tuple[tuple[Crossing, ...], bool]:
    """Pair what several sensors saw, in the order of time.

    Parameters
    ----------
    tracks
        The sightings of each sensor, in the order of time.

    Returns
    -------
    crossings
        Every sighting is in one of them; the sighting of an axle that the others did not see is
        one by itself.
    agree
        False where a sensor's times fit those of the others too seldom: one of the clocks may be
        wrong, or most wheels of the train were missed.

    Notes
    -----
    Sensors may stand apart along the track, but by less than `APART_SHARE` of the distance of
    axles, so of all axles the nearest in time is the same one; an order alone would shift all
    that follow a missing wheel. Where triggers number the axles on both sides these are paired
    by number, if their times do not contradict it: the frame that a wheel's time is taken from
    may be any of several.
    """
    # Those that triggers number first: among them no time is needed.
    seeing = sorted(
        (track for track in tracks if track),
        key=lambda track: (track[0].axle is None, -len(track)),
    )
    crossings = [Crossing((sighting,)) for sighting in (seeing[0] if seeing else ())]
    agree = True
    for track in seeing[1:]:
        matched = _matches(crossings, track)
        agree = agree and 2 * len(matched) >= len(track)
        crossings = _merged(crossings, track, matched)
    return tuple(crossings), agree


def _merged(
    crossings: Sequence[Crossing], track: Sequence[Sighting], matched: dict[int, int]
) -> list[Crossing]:
    """Put each sighting of a track to its crossing, `matched` by place, or make one of it."""
    found = {crossing: track[place] for place, crossing in matched.items()}
    both = [
        Crossing((*each.sightings, found[at])) if at in found else each
        for at, each in enumerate(crossings)
    ]
    alone = [Crossing((each,)) for place, each in enumerate(track) if place not in matched]
    return sorted([*both, *alone], key=lambda each: each.time_s)


def _matches(crossings: Sequence[Crossing], track: Sequence[Sighting]) -> dict[int, int]:
    """Return which crossing each sighting of a track belongs to, by place."""
    one = np.array([each.time_s for each in crossings])
    other = np.array([each.time_s for each in track])
    reach_one, reach_other = _reach(one, other), _reach(other, one)
    by_time = _nearest(one, other, reach_one, reach_other)
    ours, theirs = [each.sightings[0].axle for each in crossings], [each.axle for each in track]
    told = None not in ours and None not in theirs
    if not told or any(ours[at] != theirs[place] for place, at in by_time.items()):
        return by_time
    same = np.array(theirs)[:, None] == np.array(ours)
    late = np.abs(other[:, None] - one)
    near = late <= APART_SHARE * np.minimum.outer(reach_other, reach_one)
    return {int(place): int(at) for place, at in np.argwhere(same & near)}


def _nearest(
    one: FloatArray, other: FloatArray, reach_one: FloatArray, reach_other: FloatArray
) -> dict[int, int]:
    """Return which of `one` each of `other` is, by place, where both are the nearest to each."""
    lag_s = _lag_s(one, other, reach_one, reach_other)
    nearest = np.abs(other[:, None] - lag_s - one).argmin(axis=1)
    back = np.abs(one[:, None] + lag_s - other).argmin(axis=1)
    distance = np.abs(other - lag_s - one[nearest])
    mutual = back[nearest] == np.arange(len(other))
    within = distance <= PAIR_SHARE * np.minimum(reach_one[nearest], reach_other)
    return {int(place): int(nearest[place]) for place in np.flatnonzero(mutual & within)}


def _reach(times: FloatArray, others: FloatArray) -> FloatArray:
    """Return how near to each time the next axle may be: the shortest gap around.

    Not the gaps beside it: the axle beside it may be missing.
    """
    gaps = np.diff(times)
    if not len(gaps):
        spare = np.diff(others)
        return np.full(len(times), float(spare.min()) if len(spare) else LONE_S / PAIR_SHARE)
    around = range(len(times))
    return np.array([gaps[max(0, at - _NEIGHBOURS) : at + _NEIGHBOURS].min() for at in around])


def _lag_s(
    ours: FloatArray, theirs: FloatArray, reach_ours: FloatArray, reach_theirs: FloatArray
) -> float:
    """Return by how much theirs come later as the sensors stand apart: what most agree on.

    0 unless at least `LAG_VOTES` times as many agree on another: where many axles were missed, a
    few wheels of different axles lie equally far apart by chance.
    """
    nearest = np.abs(theirs[:, None] - ours).argmin(axis=1)
    late, reach = theirs - ours[nearest], np.minimum(reach_ours[nearest], reach_theirs)
    near = np.abs(late) <= APART_SHARE * reach
    late, reach = late[near], reach[near]
    agree = np.abs(late - np.append(late, 0.0)[:, None]) <= 0.5 * PAIR_SHARE * reach
    votes = agree.sum(axis=1)
    best = int(np.argmax(votes))
    if votes[best] < LAG_VOTES * max(votes[-1], 1):
        best = len(votes) - 1
    return float(np.median(late[agree[best]])) if votes[best] else 0.0
