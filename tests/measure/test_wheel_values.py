"""Readings, limits and groups: small values that must not be wrong."""

import numpy as np
import pytest
import wheel_stripes as ws

from calib import RigidTransform
from measure import (
    Alarm,
    Limit,
    Limits,
    Mounting,
    Profile,
    Quantity,
    Reading,
    Status,
    WheelFrame,
    each_wheel,
    group_into_wheels,
)
from measure.grouping import MOST_FRAMES


@pytest.mark.parametrize(
    ("value", "u95", "status"),
    [(None, None, Status.OK), (1.0, 0.1, Status.MISSING), (1.0, None, Status.OK)],
)
def test_a_reading_has_value_and_interval_or_is_missing(value, u95, status):
    with pytest.raises(ValueError, match="or is missing"):
        Reading(value, u95, status, Alarm.NONE)


def test_an_interval_is_not_negative():
    with pytest.raises(ValueError, match="u95"):
        Reading(1.0, float("nan"), Status.OK, Alarm.NONE)


@pytest.mark.parametrize(
    ("value", "u95", "alarm"),
    [
        (23.0, 0.1, Alarm.NONE),
        (22.4, 0.1, Alarm.WARNING),
        (21.9, 0.1, Alarm.ALARM),
        (33.1, 0.1, Alarm.ALARM),
        (23.0, 1.2, Alarm.WARNING),
    ],
)
def test_alarms_follow_the_limits_and_doubt_is_a_warning(value, u95, alarm):
    assert Limits.default().judge(Quantity.FLANGE_THICKNESS_10, value, u95) is alarm


def test_a_quantity_without_limit_raises_nothing():
    assert Limits("none", {}).judge(Quantity.TREAD_WEAR, 99.0, 0.1) is Alarm.NONE


@pytest.mark.parametrize("limit", [(3.0, 1.0), (float("nan"), 1.0)])
def test_a_limit_that_allows_nothing_is_refused(limit):
    with pytest.raises(ValueError, match="low < high"):
        Limit(*limit)


@pytest.mark.parametrize("name", ["wheel_radius_mm", "sigma_height_mm"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_a_mounting_without_sense_is_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Mounting(RigidTransform.identity(), **{name: value})


def test_a_profile_with_negative_sigma_is_refused():
    with pytest.raises(ValueError, match="sigma_mm"):
        Profile(np.zeros(3), np.zeros(3), -np.ones(3))


def frames(times_s, seen=None, source="train"):
    full = ws.make_stripe(np.zeros((200, 2)), np.tile([0.0, 1.0], (200, 1)))
    seen = seen if seen is not None else [True] * len(times_s)
    return [
        WheelFrame(
            full if there else full.select(np.arange(3)),
            number,
            source,
            None if at is None else int(at * 1e9),
        )
        for number, (at, there) in enumerate(zip(times_s, seen, strict=True))
    ]


def numbers(groups):
    return [[frame.frame for frame in group] for group in groups]


def test_triggered_frames_are_a_wheel_each_even_a_dark_one():
    groups = group_into_wheels(frames([0.0, 0.11, 0.25, 0.36], [True, False, True, True]))
    assert numbers(groups) == [[0], [1], [2], [3]]


def test_frames_of_a_running_camera_make_wheels_where_they_show_something():
    at = np.arange(8) / 53.0
    seen = [False, True, True, False, False, True, False, False]
    assert numbers(group_into_wheels(frames(at, seen))) == [[1, 2], [5]]


def test_pictures_without_time_are_a_wheel_each():
    assert numbers(group_into_wheels(frames([None, None]))) == [[0], [1]]


def test_a_new_source_or_a_clock_that_jumps_back_starts_a_new_wheel():
    both = frames([0.0, 0.02]) + frames([0.03], source="next")
    assert [len(group) for group in group_into_wheels(both)] == [2, 1]
    assert [len(group) for group in group_into_wheels(frames([5.0, 0.0]))] == [1, 1]


def test_no_frames_make_no_wheels():
    assert group_into_wheels([]) == ()


def test_a_wheel_that_stands_before_the_camera_is_thinned_evenly():
    at = np.arange(3 * MOST_FRAMES) / 53.0
    ((*kept,),) = group_into_wheels(frames(at))
    assert MOST_FRAMES / 2 < len(kept) <= MOST_FRAMES
    assert set(np.diff([frame.frame for frame in kept])) == {4}


def test_wheels_are_yielded_while_frames_come():
    taken = []

    def coming():
        for frame in frames(np.arange(9) / 53.0, [True, True, False] * 3):
            taken.append(frame.frame)
            yield frame

    assert [frame.frame for frame in next(each_wheel(coming()))] == [0, 1]
    assert taken == [0, 1, 2]  # the third frame shows that the first wheel has passed


def test_a_gap_without_sense_is_refused():
    with pytest.raises(ValueError, match="max_gap_s"):
        group_into_wheels([], max_gap_s=0.0)
