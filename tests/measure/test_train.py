"""Wheels of both sides become axles: whatever is missed or doubled, no axle is shifted, and none
that was counted is left out.  That frames are sorted into wheels rightly is shown elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measure import Placing, SeenWheel, Side, Track, assemble_train

LEFT, RIGHT = Side.LEFT, Side.RIGHT
COACH_M = (2.5, 16.5, 2.5, 4.0)
WAGON_M = (9.0, 5.0)
LOCOMOTIVE_M = (1.8, 1.7, 7.0, 1.8, 1.7, 5.0)
AXLE = 1000
"""A wheel's key is its axle times this, and which of its groups it is."""


def times_of(vehicles, speed_m_per_s=5.0):
    spacing = [gap for vehicle in vehicles for gap in vehicle][:-1]
    return np.concatenate([[0.0], np.cumsum(spacing)]) / speed_m_per_s


def track(side, times, axles=None, *, triggers=None, lag_s=0.0):
    """A track of one frame a wheel, its number that of the trigger."""
    axles = range(1, len(times) + 1) if axles is None else axles
    return Track(
        side,
        side,
        tuple(
            SeenWheel(AXLE * axle, float(time) + lag_s, axle, axle)
            for time, axle in zip(times, axles, strict=True)
        ),
        triggers,
    )


def numbers(axles):
    return [axle.number for axle in axles]


def placings(axles):
    return {axle.placing for axle in axles}


def seen(axles, side):
    return [axle.wheel(side).keys for axle in axles]


def true_axles(row):
    return {key // AXLE for side in Side for key in row.wheel(side).keys}


COACHES = times_of([COACH_M, COACH_M])


def test_both_sides_make_the_axles_of_a_train():
    axles = assemble_train([track(LEFT, COACHES), track(RIGHT, COACHES, lag_s=0.02)], counted=8)
    assert numbers(axles) == list(range(1, 9))
    assert placings(axles) == {Placing.CERTAIN}
    assert seen(axles, LEFT) == seen(axles, RIGHT) == [(AXLE * n,) for n in range(1, 9)]


@pytest.mark.parametrize("missing", range(1, 9))
def test_a_wheel_missing_on_one_side_shifts_nothing_and_has_a_reason(missing):
    there = [n for n in range(1, 9) if n != missing]
    right = track(RIGHT, np.delete(COACHES, missing - 1), there)
    axles = assemble_train([track(LEFT, COACHES), right], counted=8)
    assert numbers(axles) == list(range(1, 9))
    assert placings(axles) == {Placing.CERTAIN}
    assert axles[missing - 1].right.reason == "sensor right: no frame of this axle"
    assert all(axle.right.keys == axle.left.keys for axle in axles if axle.number != missing)


def test_an_axle_nobody_saw_is_told_by_the_numbers_of_the_triggers():
    there = [n for n in range(1, 9) if n != 4]
    times = np.delete(COACHES, 3)
    pair = [track(side, times, there, triggers=8) for side in Side]
    axles = assemble_train(pair, counted=8)
    assert numbers(axles) == list(range(1, 9))
    assert placings(axles) == {Placing.CERTAIN}
    assert (axles[3].left.keys, axles[3].time_s) == ((), None)


def test_trigger_numbers_that_a_camera_lost_count_of_are_not_believed():
    """The camera did not take trigger 4, and its frames are numbered on without a gap."""
    times = np.delete(COACHES, 3)
    pair = [track(side, times, range(1, 8), triggers=8) for side in Side]
    axles = assemble_train(pair, counted=8)
    assert len(axles) == 8
    assert placings(axles) == {Placing.UNPLACED}
    assert numbers(axles) == [None] * 8
    assert "seen by no sensor" in axles[0].remark


def test_trigger_numbers_of_two_sensors_that_contradict_each_other_are_not_believed():
    left = track(LEFT, [0.0, 1.0, 3.0, 4.0], [1, 2, 4, 5], triggers=5)
    right = track(RIGHT, [0.0, 1.0, 3.0, 4.0], [1, 2, 3, 5], triggers=5)
    assert placings(assemble_train([left, left], counted=5)) == {Placing.CERTAIN}
    assert Placing.CERTAIN not in placings(assemble_train([left, right], counted=5))


def test_each_side_missing_another_of_the_last_two_axles_mixes_none():
    """Beside the gap that a missing axle leaves, the next axle is near."""
    times = np.concatenate([COACHES, COACHES[-1] + np.array([5.0, 5.5])])
    left = track(LEFT, times[:-1], range(1, 10))
    right = track(RIGHT, np.delete(times, -2), [*range(1, 9), 10])
    axles = assemble_train([left, right], counted=10)
    assert numbers(axles) == list(range(1, 11))
    assert [true_axles(axle) for axle in axles] == [{n} for n in range(1, 11)]


def test_a_few_wheels_equally_far_from_others_do_not_set_the_sensors_apart():
    times = np.array([0.0, 1.8, 2.8, 3.3, 6.6, 7.1])
    left = track(LEFT, times[[0, 1, 3, 5]], [1, 2, 4, 6])
    right = track(RIGHT, times[[0, 2, 4]], [1, 3, 5])
    axles = assemble_train([left, right], counted=6)
    assert [true_axles(axle) for axle in axles] == [{n} for n in range(1, 7)]
    assert Placing.CERTAIN not in placings(axles)  # one pair is no proof that the clocks agree


def test_a_gap_that_the_train_shows_again_hides_nobody():
    times = np.cumsum([0, 1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 2, 1])
    axles = assemble_train([track(side, times) for side in Side], counted=15)
    assert placings(axles) == {Placing.UNPLACED}


def test_an_axle_nobody_saw_is_inferred_from_the_only_gap_that_hides_one():
    steady = times_of([COACH_M] * 3)
    there = [n for n in range(1, 13) if n != 6]
    pair = [track(side, np.delete(steady, 5), there) for side in Side]
    axles = assemble_train(pair, counted=12)
    assert numbers(axles) == list(range(1, 13))
    assert placings(axles) == {Placing.INFERRED}
    assert axles[5].left.keys == ()


def test_a_wheel_seen_twice_is_one_axle_and_both_sightings_are_its():
    twice = sorted([*COACHES, COACHES[2] + 0.04])
    left = track(LEFT, twice, [1, 2, 3, 3, 4, 5, 6, 7, 8])
    axles = assemble_train([left, track(RIGHT, COACHES)], counted=8)
    assert numbers(axles) == list(range(1, 9))
    assert axles[2].left.keys == (3000, 3000)


def test_a_train_so_slow_that_every_wheel_is_seen_twice_has_its_own_axles():
    slow = times_of([COACH_M, COACH_M], speed_m_per_s=0.5)
    both = np.sort(np.concatenate([slow, slow + 0.2]))
    left = track(LEFT, both, np.repeat(np.arange(1, 9), 2).tolist())
    axles = assemble_train([left, track(RIGHT, slow)], counted=8)
    assert placings(axles) == {Placing.CERTAIN}
    assert [len(keys) for keys in seen(axles, LEFT)] == [2] * 8


def test_groups_within_the_triggers_of_one_axle_are_one_wheel():
    """Three triggers an axle; axle 1 came as frame 1 and frame 3, the frame between being dark."""
    wheels = tuple(
        SeenWheel(key, time, first, last)
        for key, time, first, last in [
            (1, 0.0, 1, 1),
            (2, 0.05, 3, 3),
            (3, 0.5, 4, 6),
            (4, 1.0, 7, 9),
        ]
    )
    axles = assemble_train([Track("left", LEFT, wheels, triggers=9)], counted=3)
    assert seen(axles, LEFT) == [(1, 2), (3,), (4,)]
    assert numbers(axles) == [1, 2, 3]


def test_a_fast_train_is_paired_by_its_triggers_where_times_are_too_rough(rng):
    """At 16 m/s a bogie's axles are 150 ms apart, and three frames of a wheel 57 ms."""
    times = times_of([COACH_M, COACH_M], speed_m_per_s=16.0)

    def rough(side, axles):
        wheels = tuple(
            SeenWheel(AXLE * n, times[n - 1] + rng.uniform(-0.03, 0.03), 3 * n - 2, 3 * n)
            for n in axles
        )
        return Track(side, side, wheels, triggers=24)

    axles = assemble_train(
        [rough(LEFT, range(1, 9)), rough(RIGHT, [1, 2, 4, 5, 6, 7, 8])], counted=8
    )
    assert numbers(axles) == list(range(1, 9))
    assert placings(axles) == {Placing.CERTAIN}
    assert [true_axles(axle) for axle in axles] == [{n} for n in range(1, 9)]
    assert [bool(keys) for keys in seen(axles, RIGHT)].count(False) == 1


def test_a_train_that_goes_back_keeps_its_pairs_and_claims_no_numbers():
    there = COACHES[:5]
    back = there[-1] + 3.0 + (there[-1] - there[::-1])
    times = np.concatenate([there, back])
    labels = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]
    pair = [track(LEFT, times, labels), track(RIGHT, times, labels, lag_s=0.03)]
    axles = assemble_train(pair, counted=5)
    assert placings(axles) == {Placing.UNPLACED}
    assert seen(axles, LEFT) == seen(axles, RIGHT)
    assert "went back" in axles[0].remark


def test_a_side_without_a_sensor_and_a_silent_sensor_are_told():
    alone = track(LEFT, COACHES)
    (first, *_) = assemble_train([alone], counted=8)
    assert first.right.reason == "no sensor looks at the right side"
    silent = Track("r2", RIGHT, silent="no frame was recorded")
    (first, *_) = assemble_train([alone, silent], counted=8)
    assert first.right.reason == "sensor r2: no frame was recorded"


def test_two_sensors_of_a_side_see_the_same_wheel():
    inner, outer = track(LEFT, COACHES), replace(track(LEFT, COACHES), sensor="outer")
    axles = assemble_train([inner, outer, track(RIGHT, COACHES)], counted=8)
    assert seen(axles, LEFT) == [(AXLE * n, AXLE * n) for n in range(1, 9)]
    assert seen(axles, RIGHT) == [(AXLE * n,) for n in range(1, 9)]


def test_clocks_that_do_not_agree_are_told_and_make_no_certain_axle():
    axles = assemble_train([track(LEFT, COACHES), track(RIGHT, COACHES, lag_s=100.0)], counted=8)
    assert Placing.CERTAIN not in placings(axles)
    assert numbers(axles) == [None] * 16
    # As many seen on either side as counted together: still nothing to be sure of.
    halves = [track(LEFT, COACHES[:4]), track(RIGHT, COACHES[:4] + 100.0, [5, 6, 7, 8])]
    axles = assemble_train(halves, counted=8)
    assert placings(axles) == {Placing.INFERRED}
    assert "a clock may be wrong" in axles[0].remark


def test_without_a_count_no_number_is_certain():
    axles = assemble_train([track(side, COACHES) for side in Side])
    assert placings(axles) == {Placing.INFERRED}
    assert numbers(axles) == list(range(1, 9))


def test_a_train_nobody_saw_is_a_row_for_each_axle_counted():
    axles = assemble_train([Track("left", LEFT), Track("right", RIGHT)], counted=3)
    assert numbers(axles) == [1, 2, 3]
    assert all(axle.left.reason and axle.right.reason for axle in axles)
    assert assemble_train([], counted=0) == assemble_train([]) == ()


def test_wheels_where_none_were_counted_are_rows_without_number():
    axles = assemble_train([track(LEFT, COACHES, triggers=0)], counted=0)
    assert numbers(axles) == [None] * 8


@st.composite
def passes(draw):
    """A train of any vehicles, some wheels missed, some doubled, the sensors apart, times rough."""
    vehicles = draw(
        st.lists(st.sampled_from([COACH_M, WAGON_M, LOCOMOTIVE_M]), min_size=3, max_size=6)
    )
    times = times_of(vehicles, draw(st.floats(0.5, 30.0)))
    shortest = float(np.diff(times).min())
    tracks = []
    for side in Side:
        lag = draw(st.floats(-0.2, 0.2)) * shortest
        # Up to a quarter of a side's wheels is missed: beyond, gaps tell nothing of axles.
        missed = draw(st.sets(st.integers(0, len(times) - 1), max_size=len(times) // 4))
        doubled = draw(st.sets(st.integers(0, len(times) - 1), max_size=2)) - missed
        wheels = []
        for axle, time in enumerate(times):
            if axle in missed:
                continue
            rough = draw(st.floats(-0.03, 0.03)) * shortest
            wheels.append((axle, time + rough + lag))
            if axle in doubled:
                wheels.append((axle, time + rough + lag + 0.1 * shortest))
        tracks.append(
            Track(
                side,
                side,
                tuple(
                    SeenWheel(AXLE * (axle + 1) + place, time, place, place)
                    for place, (axle, time) in enumerate(wheels, start=1)
                ),
            )
        )
    return len(times), tracks


@st.composite
def triggered_passes(draw):
    """One trigger an axle; frames are lost on the way, or the camera did not take the trigger."""
    times = times_of(draw(st.lists(st.sampled_from([COACH_M, WAGON_M]), min_size=2, max_size=5)))
    fates = st.lists(
        st.sampled_from(["came"] * 8 + ["lost", "not taken"]),
        min_size=len(times),
        max_size=len(times),
    )
    tracks = []
    for side in Side:
        frame, wheels = 0, []
        for axle, fate in enumerate(draw(fates), start=1):
            frame += fate != "not taken"
            if fate == "came":
                wheels.append(SeenWheel(AXLE * axle, float(times[axle - 1]), frame, frame))
        tracks.append(Track(side, side, tuple(wheels), triggers=len(times)))
    return len(times), tracks


@given(passes() | triggered_passes())
def test_no_axle_is_ever_shifted_mixed_or_lost(drawn):
    counted, tracks = drawn
    axles = assemble_train(tracks, counted=counted)
    keys = [key for axle in axles for side in Side for key in axle.wheel(side).keys]
    assert sorted(keys) == sorted(wheel.key for each in tracks for wheel in each.wheels)
    assert len(axles) >= counted
    for axle in axles:
        assert len(true_axles(axle)) <= 1
        if axle.placing is Placing.CERTAIN and axle.left.keys + axle.right.keys:
            assert true_axles(axle) == {axle.number}
    known = [axle.number for axle in axles if axle.number is not None]
    assert known == sorted(set(known))
