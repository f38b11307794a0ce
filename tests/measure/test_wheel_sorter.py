"""Shows that frames sorted as they come are sorted as all at once, and that a sorter may be left
and another go on.  The rule itself is written here a second time, plainly, for finished lists."""

from itertools import groupby

import numpy as np
import wheel_stripes as ws
from hypothesis import given
from hypothesis import strategies as st

from measure import Shot, ShotJoiner, WheelFrame, WheelSorter, group_into_shots, group_into_wheels
from measure.grouping import MOST_FRAMES
from measure.shot import MIN_STRIPE_POINTS

DARK = ws.make_stripe(np.zeros((0, 2)), np.zeros((0, 2)))
POINTS = np.arange(2.0 * MIN_STRIPE_POINTS).reshape(-1, 2)
LIT = ws.make_stripe(POINTS, np.tile([0.0, 1.0], (len(POINTS), 1)))
GAPS_MS = st.sampled_from([0, 19, 38, 40, 41, 500, -5])


def frame(number, time_ms, lit, source="a.mcap", sensor=""):
    stripe = LIT if lit else DARK
    return WheelFrame(stripe, number, source, round(time_ms * 1e6), sensor)


@st.composite
def series(draw, most=40):
    """Frames as a camera may send them: late, lost, dark, its clock set back, in a next file."""
    steps = draw(st.lists(st.tuples(GAPS_MS, st.booleans(), st.integers(0, 9)), max_size=most))
    frames, time_ms, source = [], 1000, 0
    for number, (gap_ms, lit, chance) in enumerate(steps):
        time_ms += gap_ms
        source += chance == 9
        frames.append(frame(number, time_ms, lit, f"{source}.mcap"))
    return frames


def by_rule(frames):
    """Sort a finished list into wheels."""
    parts = []
    for one in frames:
        before = parts[-1][-1] if parts else None
        late = before is None or not 0 <= one.time_ns - before.time_ns <= 40_000_000
        if late or one.source != before.source:
            parts.append([])
        parts[-1].append(one)
    wheels = []
    for part in parts:
        runs = [(lit, tuple(run)) for lit, run in groupby(part, lambda one: one.shows_something)]
        shown = [run for lit, run in runs if lit]
        wheels += shown or [run for _, run in runs]
    return tuple(wheels)


def numbers(wheels):
    return [[one.frame for one in wheel] for wheel in wheels]


@given(series())
def test_wheels_are_those_of_the_rule(frames):
    assert numbers(group_into_wheels(frames)) == numbers(by_rule(frames))


@given(series(), st.integers(0, 40))
def test_a_wheel_once_returned_is_right_whatever_follows(frames, known):
    sorter = WheelSorter()
    over = [wheel for one in frames[:known] if (wheel := sorter.add(one)) is not None]
    assert numbers(over) == numbers(by_rule(frames))[: len(over)]
    assert numbers([*over, *sorter.wheels_left()]) == numbers(by_rule(frames[:known]))
    assert numbers([*over, *sorter.wheels_left(frames[known:])]) == numbers(by_rule(frames))


@given(series())
def test_a_sorter_goes_on_where_another_was_clear(frames):
    sorter, over = WheelSorter(), []
    for place, one in enumerate(frames):
        wheel = sorter.add(one)
        over += [] if wheel is None else [wheel]
        if sorter.clear:
            other = WheelSorter(shown_before=sorter.shown_before)
            assert numbers([*over, *other.wheels_left(frames[place:])]) == numbers(by_rule(frames))


def test_a_train_of_wheels_is_clear_at_the_first_frame_of_each():
    sorter, clear = WheelSorter(), []
    for number, time_ms in enumerate([0, 19, 38, 500, 519, 538, 1000]):
        sorter.add(frame(number, time_ms, lit=True))
        clear.append(sorter.clear)
    assert clear == [True, False, False, True, False, False, True]


def test_looking_at_what_is_left_changes_nothing():
    sorter = WheelSorter()
    for number in range(MOST_FRAMES + 2):
        sorter.add(frame(number, number, lit=True))
        sorter.wheels_left([frame(number + 1, number + 1, lit=False)])
    assert [len(wheel) for wheel in sorter.wheels_left()] == [MOST_FRAMES // 2 + 1]


@st.composite
def two_series(draw):
    """Frames of two sensors that one trigger starts, some lost, and an order in which they come."""
    own = {"inner": [], "outer": []}
    time_ms = 0
    for number in range(draw(st.integers(0, 15))):
        time_ms += draw(st.sampled_from([19, 500]))
        for sensor, skew_ms in zip(
            own, (0.0, draw(st.sampled_from([0.3, -0.4, 4.9]))), strict=True
        ):
            if draw(st.integers(0, 4)):
                own[sensor].append(frame(number, time_ms + skew_ms, True, sensor, sensor))
    order = draw(st.permutations([sensor for sensor, frames in own.items() for _ in frames]))
    return own, order


def members(shots):
    return [{each.sensor: each.frame for each in shot.frames} for shot in shots]


def shots_by_rule(own):
    left = {sensor: list(frames) for sensor, frames in own.items()}
    shots = []
    while any(left.values()):
        first = min(frames[0].time_ns for frames in left.values() if frames)
        near = [
            s for s, frames in left.items() if frames and frames[0].time_ns - first <= 5_000_000
        ]
        shots.append(Shot(tuple(left[sensor].pop(0) for sensor in near)))
    return shots


@given(two_series())
def test_shots_are_the_same_in_whatever_order_the_sensors_frames_come(coming):
    own, order = coming
    assert members(group_into_shots(own)) == members(shots_by_rule(own))
    joiner, certain = ShotJoiner(tuple(own)), []
    streams = {sensor: iter(frames) for sensor, frames in own.items()}
    for sensor in order:
        certain += joiner.add(sensor, next(streams[sensor]))
        assert members(certain) == members(shots_by_rule(own))[: len(certain)]
    assert members([*certain, *joiner.left()]) == members(shots_by_rule(own))
