"""From the wheels that sensors saw to the axles of a train, none shifted and none left out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from measure.train.numbers import Numbered, Placing, axles_by_triggers, number_crossings
from measure.train.pairs import join_doubles, pair
from measure.train.tracks import Side, Track


@dataclass(frozen=True, slots=True)
class WheelOfAxle:
    """One wheel of an axle: what was seen of it, or why nothing was.

    Attributes
    ----------
    keys
        What the caller knows its groups of frames by: several where it was seen twice, or by two
        sensors of its side.
    reason
        Why it was not seen; None where it was.
    """

    keys: tuple[int, ...]
    reason: str | None = None

    def __post_init__(self) -> None:
        if bool(self.keys) != (self.reason is None):
            raise ValueError(f"a wheel was seen, or has a reason; got {self!r}")


@dataclass(frozen=True, slots=True)
class Axle:
    """One axle of a train.

    Attributes
    ----------
    number
        From 1 in the order of passing; None where nothing tells it.
    placing
        How the number was come by.
    time_s
        When it passed; None where no sensor saw it.
    left, right
        Its wheels.
    remark
        What is behind a number that is not certain.
    """

    number: int | None
    placing: Placing
    time_s: float | None
    left: WheelOfAxle
    right: WheelOfAxle
    remark: str | None = None

    def wheel(self, side: Side) -> WheelOfAxle:
        """Return the wheel of a side."""
        return self.left if side is Side.LEFT else self.right


def assemble_train(tracks: Sequence[Track], *, counted: int | None = None) -> tuple[Axle, ...]:
    """Return the axles of a train from what the sensors of both sides saw.

    Parameters
    ----------
    tracks
        One for each sensor, also for one that saw nothing.
    counted
        Axles that the controller counted; None where nobody did.

    Returns
    -------
    axles
        In the order of passing; each counted axle has a row, and each group of frames is in one.
        Axles that no sensor saw stand where they belong, or unplaced at the end of the stretch
        they are missing in. Where left and right, or seen and counted, cannot be brought together
        beyond doubt, `placing` says so and no number is guessed.

    Notes
    -----
    Both sides are paired by time: sensors stand opposite each other and share a clock. Numbers
    come from the numbers of the triggers where these are complete, else from the count where as
    many were seen, else from gaps in time.
    """
    sightings = [
        join_doubles(place, tracks, axles=axles_by_triggers(track, counted), counted=counted)
        for place, track in enumerate(tracks)
    ]
    crossings, agree = pair(sightings)
    rows = number_crossings(crossings, counted)
    return tuple(_axle(row if agree else _doubted(row), tracks) for row in rows)


def _doubted(row: Numbered) -> Numbered:
    if row.placing is not Placing.CERTAIN or row.crossing is None:
        return row
    why = "left and right seldom agree in time: a clock may be wrong, or most wheels were missed"
    return replace(row, placing=Placing.INFERRED, remark=why)


def _axle(row: Numbered, tracks: Sequence[Track]) -> Axle:
    return Axle(
        number=row.number,
        placing=row.placing,
        time_s=None if row.crossing is None else row.crossing.time_s,
        left=_wheel(row, tracks, Side.LEFT),
        right=_wheel(row, tracks, Side.RIGHT),
        remark=row.remark,
    )


def _wheel(row: Numbered, tracks: Sequence[Track], side: Side) -> WheelOfAxle:
    sightings = () if row.crossing is None else row.crossing.sightings
    keys = tuple(
        wheel.key for each in sightings if tracks[each.track].side is side for wheel in each.wheels
    )
    return WheelOfAxle(keys, None if keys else _why_not(tracks, side))


def _why_not(tracks: Sequence[Track], side: Side) -> str:
    facing = [track for track in tracks if track.side is side]
    if not facing:
        return f"no sensor looks at the {side} side"
    return "; ".join(
        f"sensor {track.sensor}: {track.silent or 'no frame of this axle'}" for track in facing
    )
