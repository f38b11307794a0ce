"""How true a solved rig is, and what it says of itself.  Pictures are not rendered here."""

from dataclasses import replace

import numpy as np
import pytest
from rig_scene import (
    BOARD,
    about,
    board_errors,
    calibrated,
    drawn,
    placings,
    two_boards,
)

from calib import LaserSensor, RigidTransform, calibrate_rig

SIGMA_BOARD_MM = 0.02
NAMES = ("inner", "outer")


def _errors(answer, scene):
    """Return the errors of all rig parameters that are not held, and their covariance."""
    errors = []
    for name in answer.rig.names:
        found, true = answer.rig[name], scene.sensors[name]
        true_pose = scene.rig_from_camera[answer.anchor].inverse() @ scene.rig_from_camera[name]
        turn = found.rig_from_camera.rotation @ true_pose.rotation.T
        errors += [
            *(found.sensor.camera.parameters - true.camera.parameters),
            *(found.sensor.plane.coefficients - true.plane.coefficients),
            *RigidTransform(turn, np.zeros(3)).rotation_vector,
            *(found.rig_from_camera.translation_mm - true_pose.translation_mm),
        ]
    open_ = np.diag(answer.rig.covariance) > 0.0
    return np.array(errors)[open_], answer.rig.covariance[np.ix_(open_, open_)]


def _drawn_runs(rng, runs, *, showings=6, board_mm=SIGMA_BOARD_MM):
    """Yield answers and scenes: sensors, boards and noise are drawn anew each time."""
    sensor = calibrated(rng)
    known = dict.fromkeys(NAMES, sensor)
    for run in range(runs):
        scene = two_boards({name: drawn(sensor, rng) for name in NAMES})
        if run % 10 == 0:
            poses = placings(rng, scene, showings)
        shifts = board_errors(rng, scene, board_mm)
        seen = [
            scene.showing(f"s{index}", pose, rng, shifts, stripe_count=20)
            for index, pose in enumerate(poses)
        ]
        yield (
            calibrate_rig(seen, known, scene.boards, anchor="inner", sigma_board_mm=board_mm),
            scene,
        )


def _chi_square(error, covariance):
    scale = np.sqrt(np.diag(covariance))
    values, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    # The plane's unit normal leaves one direction of a, b, c without doubt.
    kept = values > 1e-8
    return ((axes[:, kept].T @ (error / scale)) ** 2 / values[kept]).sum(), kept.sum()


def _require_true_sigmas(rng, runs, ratio_allowed):
    found = [_errors(*each) for each in _drawn_runs(rng, runs)]
    errors = np.array([error for error, _ in found])
    sigmas = np.array([np.sqrt(np.diag(covariance)) for _, covariance in found])
    # In the pose as in the sensors: of all parameters together and of the pose's own.
    ratio = np.sqrt((errors**2).mean(axis=0) / (sigmas**2).mean(axis=0))
    assert np.sqrt((ratio**2).mean()) == pytest.approx(1.0, abs=ratio_allowed)
    squares, freedom = np.sum([_chi_square(*each) for each in found], axis=0)
    # Five standard deviations of chi square.
    assert squares / freedom == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / freedom))
    pose = [_chi_square(error[-6:], covariance[-6:, -6:])[0] for error, covariance in found]
    assert np.mean(pose) / 6.0 == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / (6 * runs)))


def test_sigmas_told_are_the_scatter_seen(rng):
    # 50 runs pin one parameter's sigma to 10 %; 26 parameters, of which some ten are apart, to 3.5.
    _require_true_sigmas(rng, 50, 0.1)


@pytest.mark.slow
def test_sigmas_told_are_the_scatter_seen_in_many_runs(rng):
    _require_true_sigmas(rng, 600, 0.035)


def _exact(rng, scene, count=6, **options):
    none = board_errors(rng, scene, 0.0)
    seen = [
        scene.showing(f"s{index}", pose, rng, none, stripe_count=30, noise=(0.0, 0.0))
        for index, pose in enumerate(placings(rng, scene, count, **options))
    ]
    return calibrate_rig(seen, scene.sensors, scene.boards, anchor="inner", sigma_board_mm=0.0)


def _assert_pose(answer, scene, name, atol_mm=1e-5):
    true = scene.rig_from_camera[answer.anchor].inverse() @ scene.rig_from_camera[name]
    found = answer.rig[name].rig_from_camera
    np.testing.assert_allclose(found.rotation, true.rotation, atol=atol_mm / 500.0)
    np.testing.assert_allclose(found.translation_mm, true.translation_mm, atol=atol_mm)


def test_points_without_noise_give_the_rig_and_the_boards(rng):
    exact = LaserSensor.exact(calibrated(rng).camera, calibrated(rng).plane)
    scene = two_boards(dict.fromkeys(NAMES, exact))
    answer = _exact(rng, scene)
    _assert_pose(answer, scene, "outer")
    one, other = answer.boards
    np.testing.assert_array_equal(one.target_from_board.rotation, np.eye(3))
    true = scene.target_from_board["one"].inverse() @ scene.target_from_board["other"]
    np.testing.assert_allclose(
        other.target_from_board.translation_mm, true.translation_mm, atol=1e-4
    )
    for view in answer.views:
        assert view.solved.dots.used.all()
        # What was seen stands in the order of what is corrected.
        for seen_px, solved in (
            (view.seen.points.centre_px, view.solved.dots),
            (view.seen.stripe.centre_px, view.solved.stripe),
        ):
            np.testing.assert_allclose(seen_px, solved.corrected_px, atol=1e-3)
    assert answer.rms_dots_px < 1e-4
    assert answer.rms_stripe_px < 1e-4


def test_one_board_that_both_cameras_see_needs_two_showings(rng):
    sensor = calibrated(rng)
    scene = two_boards({name: drawn(sensor, rng) for name in NAMES}, between_deg=40.0)
    # It faces half-way between the cameras.
    scene = replace(
        scene,
        boards={"one": BOARD},
        target_from_board={
            "one": RigidTransform(about([1.0, 0.0, 0.0], 20.0), np.zeros(3))
            @ scene.target_from_board["one"]
        },
        looks_at=dict.fromkeys(NAMES, "one"),
    )
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    poses = placings(rng, scene, 5)
    known = dict.fromkeys(NAMES, sensor)
    for count in (2, 5):
        seen = [
            scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
            for index, pose in enumerate(poses[:count])
        ]
        # Of the first, half a turn between the cameras' numberings.
        board, view = seen[0].views["outer"]
        points = view.points
        turned = replace(points, row=6 - points.row, col=7 - points.col)
        seen[0] = replace(
            seen[0], views={**seen[0].views, "outer": (board, replace(view, points=turned))}
        )
        answer = calibrate_rig(
            seen, known, scene.boards, anchor="inner", sigma_board_mm=SIGMA_BOARD_MM
        )
        turns = {(view.showing, view.sensor) for view in answer.views if view.quarters}
        assert turns == {("s0", "outer")}
        for each in answer.views:
            np.testing.assert_allclose(
                each.seen.points.centre_px, each.solved.dots.corrected_px, atol=1.0
            )
        error, covariance = _errors(answer, scene)
        # Chi square of 6 is above 27.9 once in 10,000.
        assert _chi_square(error[-6:], covariance[-6:, -6:])[0] < 27.9


def test_left_and_right_rigs_are_joined_by_a_bar(rng):
    """Four sensors, four boards on one bar; each camera sees its own."""
    exact = LaserSensor.exact(calibrated(rng).camera, calibrated(rng).plane)
    left = two_boards({"inner": exact, "outer": exact})
    across = RigidTransform(about([0.0, 1.0, 0.0], 3.0), np.array([1400.0, 5.0, -8.0]))
    scene = replace(
        left,
        sensors=dict.fromkeys(("inner", "outer", "inner right", "outer right"), exact),
        rig_from_camera={
            **left.rig_from_camera,
            **{f"{name} right": across @ pose for name, pose in left.rig_from_camera.items()},
        },
        boards={**left.boards, "one right": BOARD, "other right": BOARD},
        target_from_board={
            **left.target_from_board,
            **{
                f"{name} right": _about_bar(across) @ pose
                for name, pose in left.target_from_board.items()
            },
        },
        looks_at={**left.looks_at, "inner right": "one right", "outer right": "other right"},
    )
    # A bar 1.4 m long hardly tilts: 1 degree lifts its end by 24 mm.
    poses = [
        RigidTransform.from_rotation_vector(
            np.radians([rng.uniform(-15.0, 15.0), rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5)]),
            [0.0, 0.0, 486.0] + rng.uniform(-5.0, 5.0, 3),
        )
        for _ in range(8)
    ]
    none = board_errors(rng, scene, 0.0)
    seen = [
        scene.showing(f"s{index}", pose, rng, none, stripe_count=30, noise=(0.0, 0.0))
        for index, pose in enumerate(poses)
    ]
    answer = calibrate_rig(seen, scene.sensors, scene.boards, anchor="inner", sigma_board_mm=0.0)
    for name in scene.sensors:
        _assert_pose(answer, scene, name, atol_mm=1e-3)
    assert answer.rig.covariance.shape == (76, 76)


def _about_bar(across):
    """The same step across, between frames at the middle of the boards' places."""
    middle = RigidTransform(np.eye(3), np.array([0.0, 0.0, 486.0]))
    return middle.inverse() @ across @ middle


def test_more_showings_tell_the_rig_better(rng):
    reach = {}
    for showings in (4, 16):
        runs = _drawn_runs(np.random.default_rng(3), 3, showings=showings)
        reach[showings] = np.mean([answer.reach["outer"].sigma_mm for answer, _ in runs])
    # The sensors' own doubt and the boards' errors do not average out: less than by half.
    assert 0.4 < reach[16] / reach[4] < 0.9
