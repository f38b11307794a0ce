"""What a wheel is measured from: frames, and the shots that sensors of one rig took together."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from calib import StripePoints

MIN_STRIPE_POINTS = 100
"""A picture with fewer points on its stripe shows no wheel."""
MAX_SKEW_S = 0.005
"""Frames farther apart in time were not triggered together: a quarter of the time between frames,
and more than the clocks of two cameras differ by."""


@dataclass(frozen=True, slots=True, eq=False)
class WheelFrame:
    """The stripe of one picture, which picture it was, and which sensor of a rig took it."""

    stripe: StripePoints
    frame: int
    source: str
    time_ns: int | None = None
    sensor: str = ""

    @property
    def shows_something(self) -> bool:
        """Whether there are points enough for a wheel."""
        return len(self.stripe) >= MIN_STRIPE_POINTS

    def goes_on_from(self, before: "WheelFrame") -> bool:
        """Whether it is of the same series of pictures as an earlier frame."""
        return self.source == before.source


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """The frames that sensors of one rig took at one moment, one of each at most.

    Raises
    ------
    ValueError
        If there is no frame, or two of one sensor.
    """

    frames: tuple[WheelFrame, ...]

    def __post_init__(self) -> None:
        names = [frame.sensor for frame in self.frames]
        if not names or len(set(names)) < len(names):
            raise ValueError(f"a shot has frames, one of a sensor at most; got those of {names}")

    @property
    def time_ns(self) -> int | None:
        """When it was taken: the mean of its frames' times, None where one has none."""
        times = [frame.time_ns for frame in self.frames]
        known = [time for time in times if time is not None]
        return sum(known) // len(known) if len(known) == len(times) else None

    @property
    def shows_something(self) -> bool:
        """Whether one of its frames has points enough for a wheel."""
        return any(frame.shows_something for frame in self.frames)

    def goes_on_from(self, before: "Shot") -> bool:
        """Whether no sensor has begun another series of pictures since an earlier shot."""
        pairs = [(frame, before.of(frame.sensor)) for frame in self.frames]
        return all(old is None or frame.goes_on_from(old) for frame, old in pairs)

    def of(self, sensor: str) -> WheelFrame | None:
        """Return the frame of a sensor, or None where it took none."""
        return next((frame for frame in self.frames if frame.sensor == sensor), None)


def group_into_shots(
    frames: Mapping[str, Sequence[WheelFrame]], *, max_skew_s: float = MAX_SKEW_S
) -> tuple[Shot, ...]:
    """Join the frames of several sensors into shots; see `each_shot`."""
    return tuple(each_shot(frames, max_skew_s=max_skew_s))


def each_shot(
    frames: Mapping[str, Iterable[WheelFrame]], *, max_skew_s: float = MAX_SKEW_S
) -> Iterator[Shot]:
    """Yield one shot after another, with one frame of each sensor in memory.

    Parameters
    ----------
    frames
        Those of each sensor in the order they were taken; all with a time, or none (pictures, of
        which the first of each sensor belong together, and so on).
    max_skew_s
        Greatest time between two frames of one shot.

    Yields
    ------
    shot
        In the order of time. A frame that no other sensor took together with it is a shot by
        itself: nothing is left out.

    Raises
    ------
    ValueError
        If `max_skew_s` is negative, or some frames have a time and some have none.
    """
    if not max_skew_s >= 0.0:
        raise ValueError(f"max_skew_s must not be negative, got {max_skew_s}")
    streams = [iter(each) for each in frames.values()]
    heads = [next(stream, None) for stream in streams]
    timed = {head.time_ns is not None for head in heads if head is not None}
    if len(timed) > 1:
        raise ValueError("some sensors' frames have a time and some have none")
    if timed == {False}:
        yield Shot(tuple(head for head in heads if head is not None))
        for frames_alike in zip_longest(*streams):
            yield Shot(tuple(frame for frame in frames_alike if frame is not None))
        return
    while any(head is not None for head in heads):
        times = [_time_of(head) for head in heads]
        together = [time - min(times) <= max_skew_s * 1e9 for time in times]
        yield Shot(
            tuple(h for h, one in zip(heads, together, strict=True) if one and h is not None)
        )
        heads = [
            next(stream, None) if one else head
            for stream, head, one in zip(streams, heads, together, strict=True)
        ]


_NEVER = 1 << 80


def _time_of(frame: WheelFrame | None) -> int:
    """Return when a frame was taken; after all others where there is none."""
    if frame is None:
        return _NEVER
    if frame.time_ns is None:
        raise ValueError(f"frame {frame.frame} of {frame.source} has no time, others have one")
    return frame.time_ns
