"""Frames of a recording sorted into wheels, by time and by what they show."""

from collections.abc import Sequence
from itertools import groupby

from measure.frame import MIN_STRIPE_POINTS
from measure.wheel import WheelFrame

MAX_GAP_S = 0.04
"""Frames farther apart belong to different wheels: at 53 frames a second two missing frames end a
wheel, and no train brings the next axle (1.8 m) sooner at less than 160 km/h."""


def group_into_wheels(
    frames: Sequence[WheelFrame], *, max_gap_s: float = MAX_GAP_S
) -> tuple[tuple[WheelFrame, ...], ...]:
    """Sort frames into wheels.

    Parameters
    ----------
    frames
        In the order they were taken.
    max_gap_s
        Greatest time between frames of one wheel.

    Returns
    -------
    wheels
        Frames of each wheel. Frames without a time (pictures) are a wheel each. Frames that
        follow each other closely are one even where none of them shows anything: a wheel triggered
        them, and a wheel nobody saw is a row too. In a running series that shows wheels, frames
        that show nothing part them.

    Raises
    ------
    ValueError
        If `max_gap_s` is not positive.
    """
    if not max_gap_s > 0.0:
        raise ValueError(f"max_gap_s must be positive, got {max_gap_s}")
    wheels: list[tuple[WheelFrame, ...]] = []
    for series in _series(frames, max_gap_s):
        if not any(_shows_something(frame) for frame in series):
            wheels.append(tuple(series))
            continue
        for present, run in groupby(series, key=_shows_something):
            if present:
                wheels.append(tuple(run))
    return tuple(wheels)


def _series(frames: Sequence[WheelFrame], max_gap_s: float) -> list[list[WheelFrame]]:
    """Cut the frames wherever the next one comes too late, or from another source."""
    series: list[list[WheelFrame]] = []
    for frame in frames:
        if series and _follows(series[-1][-1], frame, max_gap_s):
            series[-1].append(frame)
        else:
            series.append([frame])
    return series


def _follows(before: WheelFrame, after: WheelFrame, max_gap_s: float) -> bool:
    if before.time_ns is None or after.time_ns is None or before.source != after.source:
        return False
    return 0 <= after.time_ns - before.time_ns <= max_gap_s * 1e9


def _shows_something(frame: WheelFrame) -> bool:
    return len(frame.stripe) >= MIN_STRIPE_POINTS
