"""Frames, or shots, of a recording sorted into wheels, by time and by what they show."""

from collections.abc import Iterable, Iterator
from itertools import groupby
from operator import itemgetter
from typing import TypeVar

from measure.shot import Shot, WheelFrame

Seen = TypeVar("Seen", WheelFrame, Shot)

MAX_GAP_S = 0.04
"""Frames farther apart belong to different wheels: at 53 frames a second two missing frames end a
wheel, and no train brings the next axle (1.8 m) sooner at less than 160 km/h."""

MOST_FRAMES = 256
"""Of a wheel that is seen longer every second frame is kept, or fewer: it stands, and more frames
of it tell nothing new."""


def group_into_wheels(
    frames: Iterable[Seen], *, max_gap_s: float = MAX_GAP_S
) -> tuple[tuple[Seen, ...], ...]:
    """Sort frames into wheels; see `each_wheel`."""
    return tuple(each_wheel(frames, max_gap_s=max_gap_s))


def each_wheel(
    frames: Iterable[Seen], *, max_gap_s: float = MAX_GAP_S
) -> Iterator[tuple[Seen, ...]]:
    """Yield the frames of one wheel after another, with those of one in memory.

    Parameters
    ----------
    frames
        In the order they were taken; or shots of a rig, in that order.
    max_gap_s
        Greatest time between frames of one wheel.

    Yields
    ------
    wheel
        Its frames, `MOST_FRAMES` at most, evenly spread. Frames without a time (pictures) are a
        wheel each. Frames that follow each other closely are one even where none of them shows
        anything: a wheel triggered them, and a wheel nobody saw is a row too. In a running series
        that shows wheels, frames that show nothing part them.

    Raises
    ------
    ValueError
        If `max_gap_s` is not positive.
    """
    if not max_gap_s > 0.0:
        raise ValueError(f"max_gap_s must be positive, got {max_gap_s}")
    for _, numbered in groupby(_by_series(frames, max_gap_s), key=itemgetter(0)):
        yield from _wheels_of_series(frame for _, frame in numbered)


def _wheels_of_series(series: Iterable[Seen]) -> Iterator[tuple[Seen, ...]]:
    shown = False
    dark: tuple[Seen, ...] = ()
    for present, run in groupby(series, key=lambda frame: frame.shows_something):
        if present:
            shown = True
            yield _thinned(run)
        elif not shown:
            dark = _thinned(run)
    if not shown:
        yield dark


def _thinned(run: Iterable[Seen]) -> tuple[Seen, ...]:
    kept: list[Seen] = []
    step = 1
    for place, frame in enumerate(run):
        if place % step == 0:
            kept.append(frame)
        if len(kept) > MOST_FRAMES:
            kept, step = kept[::2], 2 * step
    return tuple(kept)


def _by_series(frames: Iterable[Seen], max_gap_s: float) -> Iterator[tuple[int, Seen]]:
    """Give each frame the number of its series, which a late one or another source begins."""
    number, before = 0, None
    for frame in frames:
        if before is not None and not _follows(before, frame, max_gap_s):
            number += 1
        yield number, frame
        before = frame


def _follows(before: Seen, after: Seen, max_gap_s: float) -> bool:
    if before.time_ns is None or after.time_ns is None or not after.goes_on_from(before):
        return False
    return 0 <= after.time_ns - before.time_ns <= max_gap_s * 1e9
