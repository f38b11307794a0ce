"""Frames of several sensors that were triggered together."""

import numpy as np
import pytest
import wheel_stripes as ws

from measure import Shot, WheelFrame, each_wheel, group_into_shots

EMPTY = ws.make_stripe(np.zeros((0, 2)), np.zeros((0, 2)))


def frame(sensor, number, time_ms):
    time_ns = None if time_ms is None else round(time_ms * 1e6)
    return WheelFrame(EMPTY, number, f"{sensor}.mcap", time_ns, sensor)


def numbers(shots):
    return [{each.sensor: each.frame for each in shot.frames} for shot in shots]


def test_frames_of_one_trigger_are_one_shot_though_clocks_differ_a_little():
    shots = group_into_shots({
        "inner": [frame("inner", n, 20.0 * n) for n in range(3)],
        "outer": [frame("outer", n, 20.0 * n + 0.9) for n in range(3)],
    })
    assert numbers(shots) == [{"inner": n, "outer": n} for n in range(3)]
    assert shots[1].time_ns == 20_450_000


def test_a_frame_that_was_lost_shifts_no_other():
    shots = group_into_shots({
        "inner": [frame("inner", n, 20.0 * n) for n in (0, 2, 3)],
        "outer": [frame("outer", n, 20.0 * n) for n in (0, 1, 3)],
    })
    assert numbers(shots) == [
        {"inner": 0, "outer": 0},
        {"outer": 1},
        {"inner": 2},
        {"inner": 3, "outer": 3},
    ]


def test_frames_farther_apart_than_the_skew_are_not_joined():
    frames = {"inner": [frame("inner", 0, 0.0)], "outer": [frame("outer", 0, 5.5)]}
    assert len(group_into_shots(frames)) == 2
    assert len(group_into_shots(frames, max_skew_s=0.006)) == 1


def test_pictures_pair_by_their_order():
    shots = group_into_shots({
        "inner": [frame("inner", n, None) for n in range(3)],
        "outer": [frame("outer", n, None) for n in range(2)],
    })
    assert numbers(shots) == [{"inner": 0, "outer": 0}, {"inner": 1, "outer": 1}, {"inner": 2}]


def test_a_sensor_without_frames_takes_nothing_from_the_other():
    shots = group_into_shots({"inner": [], "outer": [frame("outer", 4, 1.0)]})
    assert numbers(shots) == [{"outer": 4}]
    assert group_into_shots({"inner": [], "outer": []}) == ()


@pytest.mark.parametrize("late", [[None, 1.0], [1.0, None]])
def test_frames_some_with_and_some_without_a_time_are_refused(late):
    with pytest.raises(ValueError, match="time"):
        group_into_shots({
            "inner": [frame("inner", n, time) for n, time in enumerate(late)],
            "outer": [frame("outer", n, 1.0) for n in range(2)],
        })


def test_a_shot_has_one_frame_of_a_sensor():
    with pytest.raises(ValueError, match="one of a sensor at most"):
        Shot((frame("inner", 0, 0.0), frame("inner", 1, 0.1)))


def test_shots_are_sorted_into_wheels_as_frames_are():
    times = [0.0, 19.0, 38.0, 500.0, 519.0]
    shots = [Shot((frame("inner", n, t), frame("outer", n, t))) for n, t in enumerate(times)]
    assert [len(wheel) for wheel in each_wheel(shots)] == [3, 2]
