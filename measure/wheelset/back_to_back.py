"""The distance between the flange backs of an axle, from two rigs in one frame."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.gauging.uncertainty import (
    COVERAGE_FACTOR,
    PICTURE_FLOOR_MM,
    Budget,
    whitened,
)
from measure.mounting import Survey
from measure.place import WheelPlace
from measure.quantities import Status
from measure.shot import MAX_SKEW_S
from measure.wheelset.agreement import Residuals, agreeing
from measure.wheelset.track_frame import TrackFrame

LATERAL_SPEED_MM_S = 50.0
"""How fast axles move sideways: hunting by 5 mm, one and a half times a second."""
FEWEST_PAIRS = 2
"""Of one pair nothing tells whether it is right."""


@dataclass(frozen=True, slots=True)
class BackToBack:
    """Distance between the flange backs of one axle.

    Attributes
    ----------
    value_mm, u95_mm
        The distance and the half-width of its 95 % interval; None where it is not given.
    status
        ``ok`` or ``missing``.
    pairs
        Pairs of places, left and right at one time, that it is the mean of.
    reason
        Why there is no value; None where there is one.
    """

    value_mm: float | None
    u95_mm: float | None
    status: Status
    pairs: int
    reason: str | None = None

    def __post_init__(self) -> None:
        missing = self.status is Status.MISSING
        absent = self.value_mm is None, self.u95_mm is None, self.reason is not None
        if set(absent) != {missing}:
            raise ValueError(f"it has value and u95, or is missing with a reason; got {self!r}")

    @classmethod
    def missing(cls, reason: str, pairs: int = 0) -> "BackToBack":
        """Make the distance that cannot be given."""
        return cls(None, None, Status.MISSING, pairs, reason)


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Both flange backs at one time, each (x, y, z) in its own rig's frame, and how they are off.

    The budgets are those of y; `skew_s` is by how much the left was later.
    """

    left_mm: FloatArray
    right_mm: FloatArray
    left: Budget
    right: Budget
    skew_s: float


def back_to_back(
    left: Sequence[WheelPlace],
    right: Sequence[WheelPlace],
    track: TrackFrame | None,
    survey: Survey | None = None,
    *,
    max_skew_s: float = MAX_SKEW_S,
    fewest_pairs: int = FEWEST_PAIRS,
) -> BackToBack:
    r"""Return the distance between the flange backs of one axle.

    Parameters
    ----------
    left, right
        Where the wheels of the axle stood, each in the frame of its own rig. Places whose flange
        back was not seen count for nothing: one that is only assumed never makes a distance.
    track
        The frame that holds both rigs; None where there is none.
    survey
        How well the axle's direction is known; that of `Survey` where not given.
    max_skew_s
        Places farther apart in time are no pair: the axle moves sideways meanwhile.
    fewest_pairs
        With fewer there is no value. One is enough only where no axle gives more, and a wrong
        one then stays unseen.

    Returns
    -------
    BackToBack
        Missing, with the reason, where there is no common frame, no pair, or pairs contradict
        each other.

    Notes
    -----
    With the left flange back at :math:`p_l` and the right one at :math:`p_r`, T the map
    `right_from_left` and n the axle's direction, a pair gives
    :math:`n \cdot (p_r - T p_l)`. Its doubt, to first order:

    ==================================  ==================================================
    budget of each flange back          one to one: rig, noise, vibration of its sensors
    frame: shift along the axle         one to one; the other two shifts only by n
    frame: turn about z, about x        times x, times z of the left sheet in its rig
    frame: turn about y                 times n alone: none
    direction of the axle               times how far the sheets meet the axle's two wheels
                                        apart, along the rail and in height: none if mirrored
    time between left and right         times 50 mm/s
    ==================================  ==================================================

    Yaw of the whole axle cancels between sheets that mirror each other; what is left is of
    second order, half its square times the distance: 0.2 um of 0.5 mrad, 68 um of 10 mrad in a
    curve. An axle bends under load, and the distance is not the same all around the wheels: it is
    the one where the sheets meet the flanges.

    The pairs are joined by generalised least squares, which knows what they share; a pair that
    contradicts the others is left out.
    """
    if track is None:
        return BackToBack.missing(
            "no frame holds both rigs; survey the distance of their origins, or calibrate both "
            "over one bar"
        )
    survey = survey if survey is not None else Survey()
    pairs = list(_pairs(left, right, max_skew_s))
    if len(pairs) < fewest_pairs:
        return BackToBack.missing(_too_few(left, right, len(pairs), fewest_pairs), len(pairs))
    values = np.array([_distance_mm(pair, track) for pair in pairs])
    covariance = _covariance(pairs, track, survey)
    kept = agreeing(
        len(pairs),
        lambda some: _mean(values[some], covariance[np.ix_(some, some)]).residuals,
        fewest=fewest_pairs,
    )
    if kept is None:
        return BackToBack.missing(
            f"{len(pairs)} pairs of flange backs contradict each other by {np.ptp(values):.2f} mm, "
            "and nothing tells which is right",
            len(pairs),
        )
    mean = _mean(values[kept], covariance[np.ix_(kept, kept)])
    floor_mm = np.sqrt(2.0) * PICTURE_FLOOR_MM
    u95_mm = COVERAGE_FACTOR * float(np.hypot(mean.sigma_mm, floor_mm))
    return BackToBack(mean.value_mm, u95_mm, Status.OK, len(kept))


def _pairs(
    left: Sequence[WheelPlace], right: Sequence[WheelPlace], max_skew_s: float
) -> Iterator[_Pair]:
    """Yield what both sides saw at one time, each place at most once."""
    lefts, rights = _by_time(left), _by_time(right)
    while lefts and rights:
        (left_ns, left_mm, left_budget), (right_ns, right_mm, right_budget) = lefts[0], rights[0]
        skew_s = (left_ns - right_ns) * 1e-9
        if abs(skew_s) <= max_skew_s:
            yield _Pair(left_mm, right_mm, left_budget, right_budget, skew_s)
        if skew_s <= max_skew_s:
            lefts = lefts[1:]
        if skew_s >= -max_skew_s:
            rights = rights[1:]


def _by_time(places: Sequence[WheelPlace]) -> list[tuple[int, FloatArray, Budget]]:
    """Return when, where and how well flange backs were seen, in the order of time."""
    seen = []
    for place in places:
        at_mm = _sight_mm(place)
        if place.time_ns is None or place.back_mm is None or place.back is None or at_mm is None:
            continue
        seen.append((
            place.time_ns,
            np.array([at_mm[0], place.back_mm, at_mm[1]]),
            place.back,
        ))
    return sorted(seen, key=lambda each: each[0])


def _sight_mm(place: WheelPlace) -> FloatArray | None:
    """Return rig (x, z) of the flange back; where that is not said, of the treads beside it."""
    if place.back_at_mm is not None:
        return place.back_at_mm
    if not place.treads:
        return None
    return np.asarray(np.mean([tread.place_mm for tread in place.treads], axis=0))


def _too_few(
    left: Sequence[WheelPlace], right: Sequence[WheelPlace], pairs: int, fewest: int
) -> str:
    for side, places in (("left", left), ("right", right)):
        if not any(place.back_mm is not None for place in places):
            return f"the flange back of the {side} wheel was not seen"
        if all(place.time_ns is None for place in places):
            return f"the pictures of the {side} wheel have no time: nothing pairs them"
    return f"pairs of flange backs seen at one time: {pairs}, needed: {fewest}"


def _distance_mm(pair: _Pair, track: TrackFrame) -> float:
    return float(track.axle_in_right @ _across(pair, track))


def _across(pair: _Pair, track: TrackFrame) -> FloatArray:
    """Return the way from the left flange back to the right one, in the right rig's frame."""
    left_mm = track.right_from_left.apply(pair.left_mm[None])[0]
    return np.asarray(pair.right_mm - left_mm)


def _covariance(pairs: Sequence[_Pair], track: TrackFrame, survey: Survey) -> FloatArray:
    """Return the joint covariance of the distances, mm²."""
    axle = track.axle_in_right
    by_left, by_right = -float(axle @ track.right_from_left.rotation[:, 1]), float(axle[1])
    lefts = np.stack([pair.left_mm for pair in pairs])
    across = np.stack([_across(pair, track) for pair in pairs])
    shared = np.hstack([
        by_left * np.stack([pair.left.shared_mm for pair in pairs]),
        by_right * np.stack([pair.right.shared_mm for pair in pairs]),
        whitened(track.moved_by(lefts)[:, None], track.covariance)[:, 0],
        across[:, [0, 2]] * survey.sigma_axle_direction_rad,
        np.array([[pair.skew_s * LATERAL_SPEED_MM_S] for pair in pairs]),
    ])
    single = [
        (by_left * pair.left.single_mm) ** 2 + (by_right * pair.right.single_mm) ** 2
        for pair in pairs
    ]
    return np.asarray(np.diag(single) + shared @ shared.T)


@dataclass(frozen=True, slots=True, eq=False)
class _Mean:
    value_mm: float
    sigma_mm: float
    residuals: Residuals


def _mean(values_mm: FloatArray, covariance: FloatArray) -> _Mean:
    # The floor is what no covariance shows: without it weights chase the last micrometre.
    bounded = covariance + np.eye(len(values_mm)) * PICTURE_FLOOR_MM**2
    weight = np.linalg.solve(bounded, np.ones(len(values_mm)))
    information = float(weight.sum())
    weight /= information
    mean = float(weight @ values_mm)
    return _Mean(
        value_mm=mean,
        sigma_mm=float(np.sqrt(weight @ covariance @ weight)),
        residuals=Residuals(
            values_mm - mean,
            bounded,
            np.full(covariance.shape, 1.0 / information),
            np.arange(len(values_mm)),
        ),
    )
