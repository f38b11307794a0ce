"""Frames, or shots, of a recording sorted into wheels, by time and by what they show."""

import copy
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

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
    frames: Iterable[Seen], *, max_gap_s: float = MAX_GAP_S, shown_before: bool = False
) -> Iterator[tuple[Seen, ...]]:
    """Yield the frames of one wheel after another, with those of one in memory.

    Parameters
    ----------
    frames
        In the order they were taken; or shots of a rig, in that order.
    max_gap_s, shown_before
        As of a `WheelSorter`.

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
    sorter = WheelSorter[Seen](max_gap_s=max_gap_s, shown_before=shown_before)
    for frame in frames:
        wheel = sorter.add(frame)
        if wheel is not None:
            yield wheel
    yield from sorter.wheels_left()


class WheelSorter(Generic[Seen]):
    """Sorts frames into wheels as they come; see `each_wheel`.

    Parameters
    ----------
    max_gap_s
        Greatest time between frames of one wheel.
    shown_before
        Whether the series that the first frame is of has shown a wheel already: so a sorter goes
        on where another one was `clear`.
    """

    def __init__(self, *, max_gap_s: float = MAX_GAP_S, shown_before: bool = False) -> None:
        if not max_gap_s > 0.0:
            raise ValueError(f"max_gap_s must be positive, got {max_gap_s}")
        self._max_gap_s = max_gap_s
        self._shown_before = shown_before
        self._last: Seen | None = None
        self._run: _Run[Seen] = _Run()

    def add(self, frame: Seen) -> tuple[Seen, ...] | None:
        """Take the next frame; return the wheel that it shows to be over, where it does."""
        last, self._last = self._last, frame
        goes_on = last is None or _follows(last, frame, self._max_gap_s)
        if last is not None and goes_on and last.shows_something == frame.shows_something:
            self._run = self._run.and_then(frame)
            return None
        wheel = None
        if not goes_on:
            wheel, self._shown_before = self._ended_by(last), False
        elif last is not None and last.shows_something:
            wheel, self._shown_before = self._run.kept, True
        empty: _Run[Seen] = _Run()
        self._run = empty.and_then(frame)
        return wheel

    @property
    def open_wheel(self) -> tuple[Seen, ...] | None:
        """The wheel that may still go on, as it is were nothing to follow; None where none is."""
        return self._ended_by(self._last)

    @property
    def clear(self) -> bool:
        """Whether the last frame could as well be the first of another sorter's.

        All wheels of frames before it have been returned then, and `shown_before` is what the
        other one has to be told.
        """
        return self._run.length == 1 or self.open_wheel is None

    @property
    def shown_before(self) -> bool:
        """Whether the series has shown a wheel before those frames that may still be one."""
        return self._shown_before

    def wheels_left(self, further: Iterable[Seen] = ()) -> list[tuple[Seen, ...]]:
        """Return the wheels not yet returned, as they are were only these frames to follow."""
        twin: WheelSorter[Seen] = copy.copy(self)
        wheels: list[tuple[Seen, ...] | None] = []
        for frame in further:
            wheels.append(twin.add(frame))
        wheels.append(twin.open_wheel)
        return [wheel for wheel in wheels if wheel is not None]

    def _ended_by(self, last: Seen | None) -> tuple[Seen, ...] | None:
        """Return what the run that ends with `last` is, were its series to end there."""
        if last is None or (self._shown_before and not last.shows_something):
            return None
        return self._run.kept


@dataclass(frozen=True, slots=True)
class _Run(Generic[Seen]):
    """Frames that follow each other and are alike, thinned where they are many."""

    kept: tuple[Seen, ...] = ()
    step: int = 1
    length: int = 0

    def and_then(self, frame: Seen) -> "_Run[Seen]":
        kept: tuple[Seen, ...] = self.kept
        if self.length % self.step == 0:
            kept += (frame,)
        if len(kept) > MOST_FRAMES:
            return _Run(kept[::2], 2 * self.step, self.length + 1)
        return _Run(kept, self.step, self.length + 1)


def _follows(before: Seen, after: Seen, max_gap_s: float) -> bool:
    if before.time_ns is None or after.time_ns is None or not after.goes_on_from(before):
        return False
    return 0 <= after.time_ns - before.time_ns <= max_gap_s * 1e9
