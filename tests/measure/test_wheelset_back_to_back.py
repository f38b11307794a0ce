"""The distance between flange backs is that of the axle, whichever way the axle and the rigs are
turned, and its interval holds the truth as often as it says.  Flange backs are drawn as planes: how
well one is seen in a picture is not asked here."""

from dataclasses import replace

import numpy as np
import pytest
import wheel_stripes as ws

from calib import RIG_PARAMETERS, Rig, RigidTransform, RigSensor, moved_by
from measure import (
    BACK_TO_BACK_TSI,
    Alarm,
    BackToBack,
    Status,
    Survey,
    TrackFrame,
    TreadPoint,
    WheelPlace,
    back_to_back,
)
from measure.gauging.uncertainty import Budget

BETWEEN_MM = 1500.0
TRUTH_MM = 1360.0
NOISE_MM = 0.03
# One sheet 30 degrees below the axle, ahead of it: +x on the left is -x on the right.
SIGHT = np.array([364.0, 210.0])
MIRROR = np.array([-1.0, 1.0])
SHARED = np.array([0.02, 0.03, 0.0])
SURVEY = Survey()
HALF_TURN = RigidTransform(np.diag([-1.0, -1.0, 1.0]), np.array([0.0, -BETWEEN_MM, 0.0]))
FRAME = TrackFrame.of_distance(BETWEEN_MM, sigma_mm=0.1, sigma_turn_rad=1e-4)
EXACT = TrackFrame(HALF_TURN, np.zeros((6, 6)))


def direction(yaw_rad, roll_rad):
    """Of an axle, towards the right, in the right rig's frame."""
    axle = np.array([np.tan(yaw_rad), 1.0, np.tan(roll_rad)])
    return axle / np.linalg.norm(axle)


def depth(axle, on_plane, sight):
    """Rig y at which a plane across the axle meets the line along y through (x, z)."""
    x, z = sight
    return float((axle @ on_plane - axle[0] * x - axle[2] * z) / axle[1])


def placed(time_ns, back_mm, sight, shared=SHARED):
    return WheelPlace(time_ns, back_mm, Budget(NOISE_MM, shared), (), back_at_mm=sight)


def seen(lateral_mm, frame, axle, sights, *, skew_s=0.0, speed_mm_s=0.0, time_ns=0):
    """An exact pair, left and right, of an axle that stands aside by a little."""
    left_from_right = frame.inverse()
    middle = np.array([0.0, -BETWEEN_MM / 2.0 + lateral_mm, 420.0])
    moved = middle + speed_mm_s * skew_s * axle
    right = depth(axle, middle + TRUTH_MM / 2.0 * axle, sights[1])
    on_left = left_from_right.apply((moved - TRUTH_MM / 2.0 * axle)[None])[0]
    left = depth(left_from_right.rotation @ axle, on_left, sights[0])
    late_ns = time_ns + round(skew_s * 1e9)
    return placed(late_ns, left, sights[0]), placed(time_ns, right, sights[1])


def passed(frame, axle, *, shots=5, sights=(SIGHT, MIRROR * SIGHT), **motion):
    """The places of both wheels of an axle that wanders sideways from shot to shot."""
    pairs = [
        seen(0.8 * shot, frame, axle, sights, time_ns=19_000_000 * shot, **motion)
        for shot in range(shots)
    ]
    return [left for left, _ in pairs], [right for _, right in pairs]


def with_errors(rng, places):
    common = rng.normal(size=len(SHARED)) @ SHARED
    return [
        replace(each, back_mm=each.back_mm + common + NOISE_MM * rng.normal()) for each in places
    ]


def test_rigs_that_face_each_other_read_the_distance_of_an_axle():
    found = back_to_back(*passed(HALF_TURN, direction(0.0, 0.0)), EXACT)
    assert found.value_mm == pytest.approx(TRUTH_MM, abs=1e-9)
    assert (found.status, found.pairs, found.reason) == (Status.OK, 5, None)


def test_rigs_askew_in_a_known_frame_read_the_same():
    frame = moved_by(HALF_TURN, np.array([0.004, -0.01, 0.02, 12.0, 3.0, -8.0]))
    track = TrackFrame(frame, np.zeros((6, 6)))
    # The axle as the rigs take it: along the mean of their y.
    axle = np.array([0.0, 1.0, 0.0]) - frame.rotation[:, 1]
    found = back_to_back(*passed(frame, axle / np.linalg.norm(axle)), track)
    assert found.value_mm == pytest.approx(TRUTH_MM, abs=1e-9)


def test_yaw_of_the_axle_cancels_between_sheets_that_mirror_each_other():
    straight = back_to_back(*passed(HALF_TURN, direction(0.0, 0.0)), EXACT)
    found = back_to_back(*passed(HALF_TURN, direction(0.01, 0.0)), EXACT)
    # Half of 0.01 squared times 1360.
    assert found.value_mm - TRUTH_MM == pytest.approx(0.068, abs=1e-4)
    assert found.u95_mm == pytest.approx(straight.u95_mm, rel=1e-9)


def test_yaw_counts_where_the_sheets_meet_the_axle_on_two_sides_and_is_told():
    crossed = (SIGHT, SIGHT)
    found = back_to_back(*passed(HALF_TURN, direction(5e-4, 0.0), sights=crossed), EXACT)
    # 0.5 mrad over twice 364 mm.
    assert abs(found.value_mm - TRUTH_MM) == pytest.approx(0.364, abs=1e-3)
    assert found.u95_mm > 1.96 * 0.364


def test_a_frame_by_one_distance_counts_its_turn_at_the_sheet():
    places = passed(HALF_TURN, direction(0.0, 0.0))
    exact = back_to_back(*places, EXACT).u95_mm
    turned = TrackFrame.of_distance(BETWEEN_MM, sigma_mm=1e-6, sigma_turn_rad=1e-3)
    # 1 mrad about z at x = 364 mm, and about x at z = 210 mm.
    added = 1.96 * np.hypot(0.364, 0.210)
    assert back_to_back(*places, turned).u95_mm == pytest.approx(np.hypot(exact, added), rel=1e-3)
    shifted = TrackFrame.of_distance(BETWEEN_MM, sigma_mm=0.5, sigma_turn_rad=1e-9)
    assert back_to_back(*places, shifted).u95_mm == pytest.approx(
        np.hypot(exact, 1.96 * 0.5), rel=1e-3
    )


def test_an_interval_of_the_distance_holds_the_truth_as_often_as_it_says(rng):
    spread = np.array([2e-4, 1e-4, 3e-4, 0.5, 0.08, 0.5])
    mixing = np.eye(6) + 0.3 * rng.normal(size=(6, 6))
    root = spread[:, None] * mixing
    track = TrackFrame(HALF_TURN, root @ root.T)
    sights = (SIGHT, MIRROR * SIGHT + [60.0, -40.0])
    inside = []
    for _ in range(500):
        frame = moved_by(HALF_TURN, root @ rng.normal(size=6))
        axle = direction(*rng.normal(size=2) * SURVEY.sigma_axle_direction_rad)
        left, right = passed(
            frame, axle, sights=sights, skew_s=1e-3, speed_mm_s=50.0 * rng.normal()
        )
        found = back_to_back(with_errors(rng, left), with_errors(rng, right), track, SURVEY)
        if found.value_mm is not None:
            inside.append(abs(found.value_mm - TRUTH_MM) <= found.u95_mm)
    # One in a hundred may be suspected of a contradiction; three standard deviations of 500 draws
    # are 1.3 %. Of the share inside, two standard deviations are 2 %.
    assert len(inside) >= 488
    assert 0.93 <= np.mean(inside) <= 0.97


@pytest.mark.parametrize("shots", [2, 3, 6])
def test_one_flange_back_that_is_grossly_wrong_is_left_out_or_silences_the_distance(rng, shots):
    for trial in range(30):
        left, right = passed(HALF_TURN, direction(0.0, 0.0), shots=shots)
        wrong = left[trial % shots]
        left[trial % shots] = replace(wrong, back_mm=wrong.back_mm + 2.0 * (-1) ** trial)
        found = back_to_back(with_errors(rng, left), with_errors(rng, right), FRAME)
        if shots == 2:
            assert "contradict each other by" in found.reason
        else:
            assert found.pairs < shots
            assert abs(found.value_mm - TRUTH_MM) < 3.0 / 1.96 * found.u95_mm


def test_places_are_paired_by_time_and_each_once():
    left, right = passed(HALF_TURN, direction(0.0, 0.0))
    found = back_to_back([*left[::-1], left[2]], [right[3], *right[1:]], EXACT)
    assert found.pairs == 4
    assert found.value_mm == pytest.approx(TRUTH_MM, abs=1e-9)
    late = [replace(each, time_ns=each.time_ns + 3_000_000) for each in right]
    assert back_to_back(left, late, EXACT, max_skew_s=0.002).pairs == 0
    assert back_to_back(left, late, EXACT, max_skew_s=0.003).pairs == 5


def test_time_between_left_and_right_is_paid_for():
    together = back_to_back(*passed(HALF_TURN, direction(0.0, 0.0)), EXACT)
    apart = back_to_back(*passed(HALF_TURN, direction(0.0, 0.0), skew_s=2e-3), EXACT)
    # 2 ms at 50 mm/s, in all pairs alike.
    assert apart.u95_mm == pytest.approx(np.hypot(together.u95_mm, 1.96 * 0.1), rel=1e-6)


def test_without_a_place_of_the_flange_back_the_treads_beside_it_stand_in():
    left, right = passed(HALF_TURN, direction(0.0, 0.0))
    tread = TreadPoint("inner", MIRROR * SIGHT, 0.02, np.zeros((2, 3)))
    beside = [replace(each, treads=(tread,), back_at_mm=None) for each in right]
    assert back_to_back(left, beside, FRAME) == back_to_back(left, right, FRAME)
    nowhere = [replace(each, back_at_mm=None) for each in right]
    assert back_to_back(left, nowhere, FRAME).status is Status.MISSING


def test_what_is_missing_is_said():
    left, right = passed(HALF_TURN, direction(0.0, 0.0))
    assert back_to_back(left, right, None).reason.startswith("no frame holds both rigs")
    blind = [replace(each, back_mm=None, back=None) for each in right]
    assert back_to_back(left, blind, FRAME).reason == (
        "the flange back of the right wheel was not seen"
    )
    assert back_to_back([], right, FRAME).reason == "the flange back of the left wheel was not seen"
    timeless = [replace(each, time_ns=None) for each in left]
    assert "left wheel have no time" in back_to_back(timeless, right, FRAME).reason
    assert back_to_back(left[:1], right, FRAME).reason == (
        "pairs of flange backs seen at one time: 1, needed: 2"
    )
    assert back_to_back(left[:1], right, FRAME, fewest_pairs=1).status is Status.OK


def test_one_calibration_of_both_sides_makes_the_frame_with_its_doubt(rng):
    size = len(RIG_PARAMETERS)
    sensor = ws.trackside()[0]
    left_from_left = RigidTransform.from_rotation_vector([0.3, -1.0, 0.4], [700.0, -200.0, 150.0])
    right_from_anchor = RigidTransform.from_rotation_vector([1.0, 0.2, -0.5], [-650.0, 9.0, 80.0])
    frame = moved_by(HALF_TURN, np.array([1e-3, 2e-3, -1e-3, 5.0, 2.0, 1.0]))
    left_from_anchor = frame.inverse() @ right_from_anchor
    mixed = rng.normal(size=(6, 6)) * np.array([1e-4] * 3 + [0.05] * 3)[:, None]
    covariance = np.zeros((2 * size, 2 * size))
    covariance[-6:, -6:] = mixed @ mixed.T
    poses = {"left": left_from_left, "right": left_from_anchor}
    rig = Rig(tuple(RigSensor(name, sensor, pose) for name, pose in poses.items()), covariance)
    track = TrackFrame.of_rig(rig, "right", right_from_anchor)
    np.testing.assert_allclose(track.right_from_left.rotation, frame.rotation, atol=1e-12)
    points = np.array([[364.0, -70.0, 210.0], [-200.0, -60.0, 50.0]])
    by_pose = []
    for step in mixed.T:
        moved = right_from_anchor @ moved_by(left_from_anchor, step).inverse()
        by_pose.append((moved.apply(points) - frame.apply(points)) @ track.axle_in_right)
    predicted = track.moved_by(points) @ track.covariance @ track.moved_by(points).T
    # Second order in a turn of 0.3 mrad over 1.5 m is 0.1 um of 0.3 mm.
    np.testing.assert_allclose(predicted, np.array(by_pose).T @ np.array(by_pose), rtol=2e-3)


@pytest.mark.parametrize(
    ("value", "u95", "alarm"),
    [
        (1360.0, 0.3, Alarm.NONE),
        (1362.8, 0.1, Alarm.NONE),
        (1362.8, 0.3, Alarm.WARNING),
        (1357.2, 0.3, Alarm.WARNING),
        (1363.1, 0.3, Alarm.ALARM),
        (1356.9, 0.3, Alarm.ALARM),
    ],
)
def test_a_distance_is_judged_alike_at_both_ends(value, u95, alarm):
    assert BACK_TO_BACK_TSI.judge(value, u95, grows=True) is alarm
    assert BACK_TO_BACK_TSI.judge(value, u95, grows=False) is alarm


def test_a_frame_that_is_not_mirrored_is_refused():
    with pytest.raises(ValueError, match="y points to the field on both sides"):
        TrackFrame(RigidTransform(np.eye(3), np.array([0.0, -BETWEEN_MM, 0.0])), np.eye(6))
    with pytest.raises(ValueError, match="left rig at negative y"):
        TrackFrame(RigidTransform(HALF_TURN.rotation, [0.0, BETWEEN_MM, 0.0]), np.eye(6))
    with pytest.raises(ValueError, match="symmetric"):
        TrackFrame(HALF_TURN, np.triu(np.ones((6, 6))))
    with pytest.raises(ValueError, match="positive"):
        TrackFrame.of_distance(BETWEEN_MM, sigma_mm=0.0, sigma_turn_rad=1e-3)


def test_a_distance_that_contradicts_itself_is_refused():
    with pytest.raises(ValueError, match="missing with a reason"):
        BackToBack(1360.0, 0.1, Status.MISSING, 3)
    with pytest.raises(ValueError, match="missing with a reason"):
        BackToBack(1360.0, 0.1, Status.OK, 3, "but")
