"""The distance between the flange backs of an axle, from what the rows of its wheels keep."""

from collections.abc import Sequence

from measure import Alarm, BackToBack, Limits, Survey, back_to_back
from station.documents import BackToBackDocument, StandingDocument
from station.settings import TrackSettings

NO_TRACK = (
    "measured without [track], which says how left and right stand to each other; give it in the "
    "settings"
)
"""Why no axle of a train has a distance, said once."""
_NOT_SEEN = "the {side} wheel has no flange back that was seen by a sensor with a mounting"


def back_to_back_of(
    left: Sequence[StandingDocument],
    right: Sequence[StandingDocument],
    track: TrackSettings,
    limits: Limits,
) -> BackToBackDocument:
    """Return the distance of an axle, from what was seen of each of its wheels.

    Where a wheel was seen more than once, by what saw its flange back most often: two sights of
    one wheel share doubts that their rows do not hold.
    """
    fullest = [max(seen, key=_shots, default=None) for seen in (left, right)]
    on_left, on_right = fullest
    if on_left is None or on_right is None:
        side = "left" if on_left is None else "right"
        return _document(BackToBack.missing(_NOT_SEEN.format(side=side)), limits)
    # The axle is one: what the worse of both surveys leaves open of its direction is open.
    direction = max(on_left.sigma_axle_direction_rad, on_right.sigma_axle_direction_rad)
    found = back_to_back(
        on_left.places(),
        on_right.places(),
        track.frame(),
        Survey(sigma_axle_direction_rad=direction),
        max_skew_s=track.max_skew_us * 1e-6,
        fewest_pairs=track.fewest_pairs,
    )
    return _document(found, limits)


def _shots(standing: StandingDocument) -> int:
    return len(standing.backs)


def _document(found: BackToBack, limits: Limits) -> BackToBackDocument:
    alarm = Alarm.UNKNOWN
    if found.value_mm is not None and found.u95_mm is not None:
        alarm = limits.judge_back_to_back(found.value_mm, found.u95_mm)
    return BackToBackDocument(
        value=found.value_mm,
        u95=found.u95_mm,
        status=found.status,
        alarm=alarm,
        pairs=found.pairs,
        reason=found.reason,
    )
