"""What a wheel is measured from: frames, and the shots that sensors of one rig took together."""

from collections import deque
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
    joiner = ShotJoiner(tuple(frames), max_skew_s=max_skew_s)
    streams = {sensor: iter(each) for sensor, each in frames.items()}
    heads = {sensor: next(stream, None) for sensor, stream in streams.items()}
    timed = {head.time_ns is not None for head in heads.values() if head is not None}
    if len(timed) > 1:
        raise ValueError("some sensors' frames have a time and some have none")
    if timed == {False}:
        yield Shot(tuple(head for head in heads.values() if head is not None))
        for frames_alike in zip_longest(*streams.values()):
            yield Shot(tuple(frame for frame in frames_alike if frame is not None))
        return
    for sensor, head in heads.items():
        yield from joiner.add(sensor, head)
    while wanted := joiner.waits_for:
        for sensor in wanted:
            yield from joiner.add(sensor, next(streams[sensor], None))


class ShotJoiner:
    """Joins frames of several sensors into shots as they come; see `each_shot`.

    Parameters
    ----------
    sensors
        Which frames are waited for.
    max_skew_s
        Greatest time between two frames of one shot.

    Raises
    ------
    ValueError
        If `max_skew_s` is negative, or a frame has no time.
    """

    def __init__(self, sensors: Sequence[str], *, max_skew_s: float = MAX_SKEW_S) -> None:
        if not max_skew_s >= 0.0:
            raise ValueError(f"max_skew_s must not be negative, got {max_skew_s}")
        self._max_skew_ns = max_skew_s * 1e9
        self._queues = {sensor: deque[WheelFrame]() for sensor in sensors}
        self._ended: frozenset[str] = frozenset()

    @property
    def waits_for(self) -> tuple[str, ...]:
        """The sensors without whose next frame no further shot is certain."""
        return tuple(
            sensor
            for sensor, queue in self._queues.items()
            if not queue and sensor not in self._ended
        )

    @property
    def frames_waiting(self) -> int:
        """Frames of which it is not yet certain which shot they are of."""
        return sum(map(len, self._queues.values()))

    def add(self, sensor: str, frame: WheelFrame | None) -> list[Shot]:
        """Take the next frame of a sensor, None where none follows; return the shots now certain.

        A shot is certain only when every sensor has a frame that is not of an earlier one, or has
        ended: until then the missing frame might be of this shot.
        """
        if frame is None:
            self._ended |= {sensor}
        else:
            _time_of(frame)
            self._queues[sensor].append(frame)
        shots = []
        while not self.waits_for:
            shot = _next_shot(self._queues, self._max_skew_ns)
            if shot is None:
                break
            shots.append(shot)
        return shots

    def left(self) -> list[Shot]:
        """Return the shots not yet certain, as they are were nothing to follow."""
        queues = {sensor: queue.copy() for sensor, queue in self._queues.items()}
        return list(iter(lambda: _next_shot(queues, self._max_skew_ns), None))


def _next_shot(queues: Mapping[str, deque[WheelFrame]], max_skew_ns: float) -> Shot | None:
    """Take the earliest frames, taken together, off the queues; None where none is left."""
    heads = {sensor: _time_of(queue[0]) for sensor, queue in queues.items() if queue}
    if not heads:
        return None
    first_ns = min(heads.values())
    return Shot(
        tuple(
            queues[sensor].popleft()
            for sensor, time_ns in heads.items()
            if time_ns - first_ns <= max_skew_ns
        )
    )


def _time_of(frame: WheelFrame) -> int:
    """Return when a frame was taken."""
    if frame.time_ns is None:
        raise ValueError(f"frame {frame.frame} of {frame.source} has no time, others have one")
    return frame.time_ns
