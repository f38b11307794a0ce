"""Which axle of the train a crossing is: by trigger numbers, by the count, by gaps in time."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

from measure.train.tracks import Crossing, Track

SAME_GAP = 0.05
"""Two gaps in time this close are the same distance, at the speed of a train that keeps it."""


class Placing(StrEnum):
    """How an axle's number was come by."""

    CERTAIN = "certain"
    INFERRED = "inferred"
    UNPLACED = "unplaced"


@dataclass(frozen=True, slots=True)
class Numbered:
    """A crossing, or an axle that nobody saw, and its number in the train.

    Attributes
    ----------
    crossing
        None for an axle that nobody saw.
    number
        From 1 in the order of passing; None where nothing tells it.
    placing
        How it was come by.
    remark
        What is behind a number that is not certain.
    """

    crossing: Crossing | None
    number: int | None
    placing: Placing
    remark: str | None = None


def number_crossings(crossings: Sequence[Crossing], counted: int | None) -> tuple[Numbered, ...]:
    """Give crossings their numbers, and axles nobody saw their place, in the order of passing.

    Parameters
    ----------
    crossings
        In the order of time.
    counted
        Axles that the controller counted; None where nobody did.

    Returns
    -------
    numbered
        As many as there are crossings, and as were counted. Where the two differ and neither
        trigger numbers nor gaps tell what is missing, numbers are None: a number that might be
        wrong by one is none.
    """
    if counted is None:
        why = "nobody counted the axles: one that no sensor saw would not be noticed"
        return tuple(
            Numbered(crossing, place, Placing.INFERRED, why)
            for place, crossing in enumerate(crossings, start=1)
        )
    told = _told_by_triggers(crossings, counted)
    rows: list[Numbered] = []
    known = [-1, *(at for at, number in enumerate(told) if number is not None), len(crossings)]
    numbers = [0, *(number for number in told if number is not None), counted + 1]
    gaps = _explained_gaps(crossings)
    for place in range(len(known) - 1):
        start, end = known[place], known[place + 1]
        free = range(numbers[place] + 1, numbers[place + 1])
        rows += _fill(crossings, range(start + 1, end), free, gaps)
        if end < len(crossings):
            rows.append(Numbered(crossings[end], numbers[place + 1], Placing.CERTAIN))
    return tuple(rows)


def axles_by_triggers(track: Track, counted: int | None) -> tuple[int, ...] | None:
    """Return the axle of each of a track's wheels, where the frames' numbers tell it.

    A trigger that the camera did not take makes all later frames' numbers too small, and no
    number is missing. So they count only if the last is of the last axle, and every group of
    frames lies within the triggers of one axle.
    """
    if not (track.wheels and track.triggers and counted) or track.triggers % counted:
        return None
    each = track.triggers // counted
    first = [(wheel.first - 1) // each + 1 for wheel in track.wheels]
    last = [(wheel.last - 1) // each + 1 for wheel in track.wheels]
    complete = first == last and last[-1] == counted and first[0] >= 1
    return tuple(first) if complete and sorted(first) == first else None


def _told_by_triggers(crossings: Sequence[Crossing], counted: int) -> list[int | None]:
    """Return the number of each crossing by those of its frames, None where they tell none."""
    found = [
        {each.axle for each in crossing.sightings if each.axle is not None}
        for crossing in crossings
    ]
    told = [next(iter(numbers), None) for numbers in found]
    agree = all(len(numbers) <= 1 for numbers in found)
    return told if agree and _leaves_room(told, counted) else [None] * len(crossings)


def _leaves_room(told: Sequence[int | None], counted: int) -> bool:
    """Tell whether known numbers rise, with enough between for what stands between."""
    before, waiting = 0, 0
    for number in [*told, counted + 1]:
        if number is None:
            waiting += 1
            continue
        if number - before - 1 < waiting:
            return False
        before, waiting = number, 0
    return True


def _fill(
    crossings: Sequence[Crossing], places: range, free: range, gaps: Sequence[int]
) -> list[Numbered]:
    """Give the crossings at `places` the numbers that are free for them."""
    missing = len(free) - len(places)
    if missing == 0:
        return [
            Numbered(crossings[at], number, Placing.CERTAIN)
            for at, number in zip(places, free, strict=True)
        ]
    if missing < 0:
        return _with_surplus(crossings, places, free)
    if not places:
        return [_not_seen(number, Placing.CERTAIN) for number in free]
    holes = [at for at in gaps if places.start <= at < places.stop - 1]
    if len(holes) == missing:
        return _with_holes(crossings, places, free, holes)
    why = (
        f"{missing} of {len(free)} axles were seen by no sensor, and nothing tells "
        "which: this may be any of several"
    )
    seen = [Numbered(crossings[at], None, Placing.UNPLACED, why) for at in places]
    return [*seen, *(_not_seen(None, Placing.UNPLACED) for _ in range(missing))]


def _with_holes(
    crossings: Sequence[Crossing], places: range, free: range, holes: Sequence[int]
) -> list[Numbered]:
    rows: list[Numbered] = []
    numbers = iter(free)
    why = "by the gaps in time between the axles, at a steady speed"
    for at in places:
        rows.append(Numbered(crossings[at], next(numbers), Placing.INFERRED, why))
        if at in holes:
            rows.append(_not_seen(next(numbers), Placing.INFERRED))
    return rows


def _with_surplus(crossings: Sequence[Crossing], places: range, free: range) -> list[Numbered]:
    """Give numbers where there are too few: what one sensor alone saw is the surplus."""
    alone = [at for at in places if len(crossings[at].sightings) == 1]
    surplus = len(places) - len(free)
    too_many = f"{len(places)} crossings of {len(free)} axles counted"
    if len(alone) != surplus or len(alone) == len(places):
        why = f"{too_many}: a train that went back, or a wrong count; nothing tells which these are"
        return [Numbered(crossings[at], None, Placing.UNPLACED, why) for at in places]
    numbers = iter(free)
    doubt = f"{too_many}: seen by one sensor alone, perhaps an axle seen twice"
    why = f"{too_many}: those that one sensor alone saw are taken for the surplus"
    return [
        Numbered(crossings[at], None, Placing.UNPLACED, doubt)
        if at in alone
        else Numbered(crossings[at], next(numbers), Placing.INFERRED, why)
        for at in places
    ]


def _not_seen(number: int | None, placing: Placing) -> Numbered:
    return Numbered(None, number, placing, "counted, but seen by no sensor")


def _explained_gaps(crossings: Sequence[Crossing]) -> list[int]:
    """Return the places after which, by the gaps in time, one axle is missing.

    A gap that the train shows once hides an axle if elsewhere, between gaps like its neighbours,
    two gaps stand that make as much. Where the train changes its speed no gap equals another, and
    none is found.
    """
    gaps = [after.time_s - before.time_s for before, after in pairwise(crossings)]
    return [at for at in range(len(gaps)) if _hides_one(at, gaps)]


def _hides_one(at: int, gaps: Sequence[float]) -> bool:
    if any(_alike(gaps[at], other) for place, other in enumerate(gaps) if place != at):
        return False
    return any(
        _alike(gaps[at], gaps[place] + gaps[place + 1])
        and _alike(_at(gaps, at - 1), _at(gaps, place - 1))
        and _alike(_at(gaps, at + 1), _at(gaps, place + 2))
        for place in range(len(gaps) - 1)
    )


def _at(gaps: Sequence[float], place: int) -> float:
    """Return a gap; 0 beyond the ends of the train."""
    return gaps[place] if 0 <= place < len(gaps) else 0.0


def _alike(one: float, other: float) -> bool:
    return abs(one - other) <= SAME_GAP * max(one, other)
