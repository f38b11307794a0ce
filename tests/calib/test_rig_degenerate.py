"""Showings that leave open how the cameras stand: refused with what is open, or told."""

import re
from dataclasses import replace

import numpy as np
import pytest
from rig_scene import board_errors, calibrated, drawn, placings, two_boards

from calib import Degenerate, RigidTransform, RigShowing, TooFewViews, calibrate_rig

SIGMA_BOARD_MM = 0.02


@pytest.fixture
def told(rng):
    return dict.fromkeys(("inner", "outer"), calibrated(rng))


@pytest.fixture
def scene(rng, told):
    return two_boards({name: drawn(sensor, rng) for name, sensor in told.items()})


def _placed(turns, rng):
    return [
        RigidTransform.from_rotation_vector(turn, [0.0, 0.0, 486.0] + rng.uniform(-20.0, 20.0, 3))
        for turn in turns
    ]


def _calibrated(poses, scene, told, rng):
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    showings = [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
        for index, pose in enumerate(poses)
    ]
    return calibrate_rig(
        showings, told, scene.boards, anchor="inner", sigma_board_mm=SIGMA_BOARD_MM
    )


def test_target_that_was_only_shifted_is_refused(scene, told, rng):
    poses = _placed(np.tile([0.1, 0.05, 0.0], (8, 1)), rng)
    with pytest.raises(Degenerate, match="shifted but not turned.*open along every axis"):
        _calibrated(poses, scene, told, rng)


@pytest.mark.parametrize("axis", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.4, 0.5, 0.768]])
def test_turns_about_one_axis_are_refused_and_the_axis_is_named(axis, scene, told, rng):
    turns = np.outer(np.radians(rng.uniform(-15.0, 15.0, 8)), axis)
    with pytest.raises(
        Degenerate, match="shift between the two cameras along this axis"
    ) as told_so:
        _calibrated(_placed(turns, rng), scene, told, rng)
    named = re.search(r"\((.*?), (.*?), (.*?)\) in the frame of camera 'inner'", str(told_so.value))
    found = np.array([float(part) for part in named.groups()])
    # Two decimals, of poses known to some 1e-3 rad beside turns of 0.1.
    np.testing.assert_allclose(found, np.array(axis) * np.sign(found @ axis), atol=0.03)


def test_one_axis_shows_through_a_false_showing(scene, told, rng):
    turns = np.outer(np.radians(np.linspace(-15.0, 15.0, 8)), [0.0, 1.0, 0.0])
    turns[3] = [0.2, 0.0, 0.0]
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    poses = _placed(turns, rng)
    showings = [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
        for index, pose in enumerate(poses)
    ]
    moved = RigidTransform(np.eye(3), np.array([9.0, 0.0, 4.0])) @ poses[3]
    later = scene.showing("s3", moved, rng, shifts, stripe_count=30)
    showings[3] = RigShowing("s3", {**showings[3].views, "outer": later.views["outer"]})
    with pytest.raises(Degenerate, match="axis|mm only|agree"):
        calibrate_rig(showings, told, scene.boards, anchor="inner", sigma_board_mm=SIGMA_BOARD_MM)


def test_second_axis_of_a_little_is_told_with_the_sigma_it_leaves(scene, told, rng):
    angles = np.radians(rng.uniform(-15.0, 15.0, 8))
    turns = np.outer(angles, [0.0, 1.0, 0.0])
    turns[:, 0] = np.radians(rng.uniform(-3.0, 3.0, 8))
    answer = _calibrated(_placed(turns, rng), scene, told, rng)
    sigma_mm = answer.reach["outer"].sigma_mm
    assert 0.15 < sigma_mm < 1.0
    (warning,) = [text for text in answer.warnings if "known in the rig" in text]
    assert f"{sigma_mm:.2g} mm" in warning
    assert "turned by 20 degrees" in warning


def test_two_showings_of_two_boards_are_too_few(scene, told, rng):
    with pytest.raises(TooFewViews, match="2 showings to 'inner' and 'outer'.*at least 3"):
        _calibrated(placings(rng, scene, 2), scene, told, rng)


def test_one_showing_of_one_board_leaves_its_numbering_open(rng, told):
    scene = two_boards(dict(told), between_deg=30.0)
    scene = replace(scene, looks_at=dict.fromkeys(told, "one"))
    pose = RigidTransform.from_rotation_vector([0.25, 0.0, 0.0], [0.0, 0.0, 486.0])
    with pytest.raises(Degenerate, match="from which corner"):
        _calibrated([pose], scene, told, rng)
    further = RigidTransform.from_rotation_vector([0.1, 0.2, 0.1], [5.0, 0.0, 480.0])
    assert _calibrated([pose, further], scene, told, rng).left_out == {}


def test_three_well_turned_showings_suffice(scene, told, rng):
    turns = np.radians([[15.0, 10.0, 0.0], [-15.0, 5.0, 5.0], [0.0, -18.0, -5.0]])
    answer = _calibrated(_placed(turns, rng), scene, told, rng)
    true = scene.rig_from_camera["outer"]
    middle = np.array([[0.0, 0.0, 486.0]])
    miss = answer.rig["outer"].rig_from_camera.apply(middle) - true.apply(middle)
    assert np.linalg.norm(miss) < 5.0 * max(answer.reach["outer"].sigma_mm, 0.1)


def test_cameras_that_share_no_showing_are_refused_by_name(scene, told, rng):
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    showings = [
        scene.showing(f"{name} {index}", pose, rng, shifts, stripe_count=30, sensors=[name])
        for index, pose in enumerate(placings(rng, scene, 4))
        for name in ("inner", "outer")
    ]
    with pytest.raises(Degenerate, match="sensor 'outer' shares no showing with 'inner'"):
        calibrate_rig(showings, told, scene.boards, anchor="inner")


def test_showings_none_of_which_agree_are_refused(scene, told, rng):
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    poses, others = placings(rng, scene, 8), placings(rng, scene, 8)
    showings = []
    for index, (pose, other) in enumerate(zip(poses, others, strict=True)):
        one = scene.showing("", pose, rng, shifts, stripe_count=30)
        later = scene.showing("", other, rng, shifts, stripe_count=30)
        views = {"inner": one.views["inner"], "outer": later.views["outer"]}
        showings.append(RigShowing(f"s{index}", views))
    with pytest.raises(Degenerate, match="agree|contradict"):
        calibrate_rig(showings, told, scene.boards, anchor="inner")
