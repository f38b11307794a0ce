"""Of stripes that lie over one another the wheel: the one smooth curve with most points in it."""

from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray, IntArray

_BIN_MM = 1.0
_GAP_MM = 0.8
# A path may leave out so many places that hold points; more would be two paths.
_LOOK_BACK = 30
_MOST_JUMP = 30.0
_MOST_MISFIT_MM = 3.0
_MISFIT_WEIGHT = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class _Clusters:
    """Points that lie together within a millimetre of the profile.

    `member` is the number of each point's cluster; the other fields are one per cluster, in order
    along the profile: bin, height outside, share of a full bin, cost of being off the reference.
    """

    member: IntArray
    bin: IntArray
    outside_mm: FloatArray
    fill: FloatArray
    misfit: FloatArray


def one_layer(along_mm: FloatArray, outside_mm: FloatArray, unworn: BoolArray) -> BoolArray:
    """Tell which points make one profile, where several lie over another.

    Parameters
    ----------
    along_mm, outside_mm
        Shape (N,): place along the reference and height over it.
    unworn
        Shape (N,): where the profile can be expected on the reference.

    Returns
    -------
    keep
        Shape (N,).

    Notes
    -----
    A profile is a function: one height at each place. Points of a millimetre are gathered in
    clusters; of all ways through them, one cluster a place at most, the best is found by dynamic
    programming: it is rewarded for points, and pays for jumps and for being off the reference
    where nothing wears.
    """
    if len(along_mm) == 0:
        return np.zeros(0, dtype=bool)
    clusters = _clusters(along_mm, outside_mm, unworn)
    if len(np.unique(clusters.bin)) == len(clusters.bin):
        return np.ones(len(along_mm), dtype=bool)
    return np.isin(clusters.member, _best_path(clusters))


def _clusters(along_mm: FloatArray, outside_mm: FloatArray, unworn: BoolArray) -> _Clusters:
    place = np.floor(along_mm / _BIN_MM).astype(np.int64)
    order = np.lexsort((outside_mm, place))
    starts = (np.diff(place[order]) > 0) | (np.diff(outside_mm[order]) > _GAP_MM)
    number = np.concatenate([[0], np.cumsum(starts)])
    member = np.empty(len(order), dtype=np.int64)
    member[order] = number
    count = np.bincount(member)
    height = np.bincount(member, outside_mm) / count
    off = np.minimum(np.abs(height), _MOST_MISFIT_MM)
    cost = _MISFIT_WEIGHT * off * (np.bincount(member, unworn) / count)
    first = order[np.concatenate([[0], np.flatnonzero(starts) + 1])]
    return _Clusters(member, place[first], height, np.minimum(count / np.median(count), 1.0), cost)


def _best_path(clusters: _Clusters) -> IntArray:
    """Return the clusters of the best way from one end to the other."""
    count = len(clusters.bin)
    value = clusters.fill - clusters.misfit
    before = np.full(count, -1, dtype=np.int64)
    rank = np.unique(clusters.bin, return_inverse=True)[1]
    first_of_rank = np.searchsorted(rank, np.arange(rank[-1] + 1))
    for here in range(count):
        low = first_of_rank[max(rank[here] - _LOOK_BACK, 0)]
        earlier = np.arange(low, first_of_rank[rank[here]])
        if not len(earlier):
            continue
        apart = clusters.bin[here] - clusters.bin[earlier]
        climb = np.abs(clusters.outside_mm[here] - clusters.outside_mm[earlier])
        total = value[earlier] - np.minimum(climb**2 / (0.5 + 0.1 * apart), _MOST_JUMP)
        best = int(np.argmax(total))
        if total[best] > 0.0:
            value[here] += total[best]
            before[here] = earlier[best]
    path = [int(np.argmax(value))]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path)
