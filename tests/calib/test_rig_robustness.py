"""What a rig's solve survives, and what it tells of it.  Accuracy is looked at elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from rig_scene import BOARD, board_errors, calibrated, drawn, placings, two_boards

from calib import Cause, LightPlane, RigidTransform, RigShowing, TooFewViews, calibrate_rig

SIGMA_BOARD_MM = 0.02


@pytest.fixture
def told(rng):
    return dict.fromkeys(("inner", "outer"), calibrated(rng))


@pytest.fixture
def scene(rng, told):
    return two_boards({name: drawn(sensor, rng) for name, sensor in told.items()})


def _showings(scene, rng, count=8, **options):
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    return [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30, **options)
        for index, pose in enumerate(placings(rng, scene, count))
    ]


def _solved(showings, told, scene, anchor="inner"):
    return calibrate_rig(showings, told, scene.boards, anchor=anchor, sigma_board_mm=SIGMA_BOARD_MM)


def _surprise(answer, scene, anchor="inner", other="outer"):
    """Chi square of the other camera's pose, 6 degrees of freedom."""
    true = scene.rig_from_camera[anchor].inverse() @ scene.rig_from_camera[other]
    found = answer.rig[other].rig_from_camera
    turn = RigidTransform(found.rotation @ true.rotation.T, np.zeros(3)).rotation_vector
    miss = np.concatenate([turn, found.translation_mm - true.translation_mm])
    columns = answer.rig.columns(other)[-6:]
    return miss @ np.linalg.solve(answer.rig.covariance[np.ix_(columns, columns)], miss)


def _from_other_corner(view):
    row, col = BOARD.rows - 1 - view.points.row, BOARD.cols - 1 - view.points.col
    return replace(view, points=replace(view.points, row=row, col=col))


def _with_view(showing, sensor, change):
    board, view = showing.views[sensor]
    return RigShowing(showing.name, {**showing.views, sensor: (board, change(view))})


# Chi square of 6 is above 27.9 once in 10,000.
MOST_SURPRISE = 27.9


@pytest.mark.parametrize("anchor", ["inner", "outer"])
def test_either_sensor_carries_the_frame(anchor, scene, told, rng):
    other = "outer" if anchor == "inner" else "inner"
    answer = _solved(_showings(scene, rng), told, scene, anchor)
    np.testing.assert_array_equal(answer.rig[anchor].rig_from_camera.rotation, np.eye(3))
    own = answer.rig.columns(anchor)[-6:]
    assert not answer.rig.covariance[own].any()
    assert answer.rig.names == ("inner", "outer")
    assert _surprise(answer, scene, anchor, other) < MOST_SURPRISE
    assert answer.warnings == ()


def test_target_moved_between_the_pictures_is_noticed(scene, told, rng):
    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    poses = placings(rng, scene, 9)
    for moved_mm, says in (
        (5.0, "contradict"),
        (0.3, "fit the rig|contradict"),
        (0.06, "contradict"),
    ):
        showings = [
            scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
            for index, pose in enumerate(poses)
        ]
        shift = RigidTransform(np.eye(3), np.array([0.6, 0.8, 0.0]) * moved_mm)
        later = scene.showing("s4", shift @ poses[4], rng, shifts, stripe_count=30)
        views = {"inner": showings[4].views["inner"], "outer": later.views["outer"]}
        showings[4] = RigShowing("s4", views)
        answer = _solved(showings, told, scene)
        assert list(answer.left_out) == ["s4"]
        assert any(part in answer.left_out["s4"] for part in says.split("|"))
        assert all(view.solved.left_out for view in answer.views if view.showing == "s4")
        assert _surprise(answer, scene) < MOST_SURPRISE


def test_gross_errors_of_dots_and_stripe_have_no_pull_and_a_name(scene, told, rng):
    def spoilt(view):
        centre, stripe = view.points.centre_px.copy(), view.stripe.centre_px.copy()
        centre[:5] += [3.0, -4.0]
        stripe[:4] += 2.0 * view.stripe.normal[:4]
        return replace(
            view,
            points=replace(view.points, centre_px=centre),
            stripe=replace(view.stripe, centre_px=stripe),
        )

    showings = [_with_view(each, "outer", spoilt) for each in _showings(scene, rng)]
    answer = _solved(showings, told, scene)
    assert _surprise(answer, scene) < MOST_SURPRISE
    for view in answer.views:
        if view.sensor == "outer":
            assert view.solved.dots.cause[:5] == (Cause.OUTLIER,) * 5
            assert not view.solved.stripe.used[:4].any()
    # 5 of 56.
    assert answer.fits["outer"].outlier_fraction_dots == pytest.approx(5 / 56, abs=0.02)
    assert answer.fits["inner"].outlier_fraction_dots < 0.01


def test_stripe_false_as_a_whole_is_not_used(scene, told, rng):
    def shifted(view):
        stripe = replace(view.stripe, centre_px=view.stripe.centre_px + 8.0 * view.stripe.normal)
        return replace(view, stripe=stripe)

    showings = _showings(scene, rng)
    showings[2] = _with_view(showings[2], "inner", shifted)
    answer = _solved(showings, told, scene)
    (view,) = [each for each in answer.views if (each.showing, each.sensor) == ("s2", "inner")]
    assert not view.solved.stripe.used.any()
    assert set(view.solved.stripe.cause) == {Cause.STRAY_LIGHT}
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_of_several_lines_the_one_near_the_known_sheet_is_the_stripe(scene, told, rng):
    def doubled(view):
        false = replace(view.stripe, centre_px=view.stripe.centre_px + 40.0 * view.stripe.normal)
        return replace(view, stripe=false, rivals=(view.stripe,))

    showings = [_with_view(each, "inner", doubled) for each in _showings(scene, rng)]
    answer = _solved(showings, told, scene)
    assert all(view.solved.stripe.used.mean() > 0.9 for view in answer.views)
    assert answer.warnings == ()
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_camera_of_other_pixels_contradicts_its_calibration(scene, told, rng):
    true = scene.sensors["outer"]
    # Of what the dots tell by themselves, the ratio of fx and fy is the surest.
    camera = replace(true.camera, fy=true.camera.fy + 8.0)
    scene = replace(scene, sensors={**scene.sensors, "outer": replace(true, camera=camera)})
    showings = [
        _with_view(each, "outer", lambda view: replace(view, stripe=None))
        for each in _showings(scene, rng)
    ]
    warnings = _solved(showings, told, scene).warnings
    (warning,) = [text for text in warnings if "contradict the calibration" in text]
    assert "'outer'" in warning


def test_sensor_that_was_bent_since_its_calibration_is_told(scene, told, rng):
    plane = scene.sensors["outer"].plane
    bent = LightPlane(plane.normal_in_cam, plane.offset_mm + 1.0)
    truth = {**scene.sensors, "outer": replace(scene.sensors["outer"], plane=bent)}
    scene = replace(scene, sensors=truth)
    answer = _solved(_showings(scene, rng), told, scene)
    (warning,) = answer.warnings
    assert warning.startswith("the sheet of 'outer' lies 1")
    assert "calibrate the sensor anew" in warning
    found = answer.rig["outer"].sensor.plane
    sigma_mm = np.sqrt(answer.rig.covariance[answer.rig.columns("outer")[12]][19 + 12])
    assert abs(found.offset_mm - bent.offset_mm) < 5.0 * sigma_mm
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_boards_numbered_from_the_other_corner_are_found(scene, told, rng):
    showings = _showings(scene, rng)
    plain = _solved(showings, told, scene)

    for place, sensor in ((0, "inner"), (3, "outer"), (5, "inner"), (5, "outer")):
        showings[place] = _with_view(showings[place], sensor, _from_other_corner)
    answer = _solved(showings, told, scene)
    found = {(view.showing, view.sensor) for view in answer.views if view.quarters}
    assert found == {("s0", "inner"), ("s3", "outer"), ("s5", "inner"), ("s5", "outer")}
    np.testing.assert_allclose(
        answer.rig["outer"].rig_from_camera.translation_mm,
        plain.rig["outer"].rig_from_camera.translation_mm,
        atol=1e-4,
    )
    np.testing.assert_allclose(answer.rig.covariance, plain.rig.covariance, rtol=1e-2, atol=1e-9)


def test_boards_numbered_by_chance_are_found(scene, told, rng):
    showings = _showings(scene, rng)
    turned = {}
    for place, showing in enumerate(showings):
        for sensor in showing.views:
            turned[showing.name, sensor] = rng.random() < 0.5
            if turned[showing.name, sensor]:
                showings[place] = _with_view(showings[place], sensor, _from_other_corner)
    answer = _solved(showings, told, scene)
    assert answer.left_out == {}
    for sensor in told:
        # Which of the two numberings is the board's own is nobody's to say.
        same = {
            bool(view.quarters) == turned[view.showing, view.sensor]
            for view in answer.views
            if view.sensor == sensor
        }
        assert len(same) == 1
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_boards_side_by_side_are_numbered_right_too(told, rng):
    """A bar with two boards that face the same way: turns alone do not tell the numberings."""
    scene = two_boards({name: drawn(sensor, rng) for name, sensor in told.items()}, between_deg=0.0)
    beside = RigidTransform(np.eye(3), np.array([300.0, 0.0, 0.0]))
    scene = replace(
        scene,
        rig_from_camera={
            **scene.rig_from_camera,
            "outer": beside @ scene.rig_from_camera["outer"],
        },
        target_from_board={
            **scene.target_from_board,
            "other": beside @ scene.target_from_board["other"],
        },
    )

    shifts = board_errors(rng, scene, SIGMA_BOARD_MM)
    showings = [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
        for index, pose in enumerate(placings(rng, scene, 8, tilt_deg=6.0))
    ]
    for sensor in ("inner", "outer"):
        showings[2] = _with_view(showings[2], sensor, _from_other_corner)
    answer = _solved(showings, told, scene)
    assert {view.showing for view in answer.views if view.quarters} == {"s2"}
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_showing_of_one_camera_still_serves(scene, told, rng):
    pairs = _showings(scene, rng, 5)
    single = [
        replace(each, name=f"{each.name} alone")
        for each in _showings(scene, rng, 4, sensors=["outer"])
    ]
    answer = _solved([*pairs, *single], told, scene)
    assert (answer.fits["outer"].views, answer.fits["outer"].paired) == (9, 5)
    assert _surprise(answer, scene) < MOST_SURPRISE
    alone = [view for view in answer.views if view.showing.endswith("alone")]
    assert all(view.solved.stripe.used.mean() > 0.9 for view in alone)


def test_unusable_picture_is_named_and_the_other_of_its_showing_serves(scene, told, rng):
    def cut(view):
        points = view.points
        few = replace(
            points,
            row=points.row[:4],
            col=points.col[:4],
            centre_px=points.centre_px[:4],
            sigma_px=points.sigma_px[:4],
            cause=points.cause[:4],
        )
        return replace(view, points=few)

    showings = _showings(scene, rng)
    showings[1] = _with_view(showings[1], "outer", cut)
    answer = _solved(showings, told, scene)
    (view,) = [each for each in answer.views if each.solved.left_out]
    assert (view.showing, view.sensor) == ("s1", "outer")
    assert "4 target points" in view.solved.left_out
    assert any("s1, outer: 4 target points" in warning for warning in answer.warnings)
    assert answer.fits["inner"].views == 8
    assert answer.fits["inner"].paired == 7


def test_board_printed_worse_than_told_is_told(scene, told, rng):
    shifts = board_errors(rng, scene, 0.06)
    showings = [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=30)
        for index, pose in enumerate(placings(rng, scene, 8))
    ]
    answer = _solved(showings, told, scene)
    assert sum("off their places" in warning for warning in answer.warnings) == 2
    # 168 coordinates pin a standard deviation to 5.5 %; the depths of dots hardly show.
    for board in answer.boards:
        assert board.found_sigma_mm == pytest.approx(0.06, rel=0.25)


def test_sheet_that_no_picture_shows_is_told_and_left_as_it_was(scene, told, rng):
    showings = [
        _with_view(each, "outer", lambda view: replace(view, stripe=None))
        for each in _showings(scene, rng)
    ]
    answer = _solved(showings, told, scene)
    assert any("no stripe of 'outer'" in warning for warning in answer.warnings)
    own = answer.rig.columns("outer")[12]
    before = told["outer"].covariance[12, 12]
    assert 0.5 * before < answer.rig.covariance[own, own] < 1.001 * before


def test_sensor_that_is_exact_is_held(scene, told, rng):
    sensors = {**told, "inner": replace(told["inner"], covariance=np.zeros((13, 13)))}
    truth = {**scene.sensors, "inner": sensors["inner"]}
    scene = replace(scene, sensors=truth)
    answer = _solved(_showings(scene, rng), sensors, scene)
    own = answer.rig.columns("inner")
    assert not answer.rig.covariance[own].any()
    np.testing.assert_array_equal(
        answer.rig["inner"].sensor.camera.parameters, sensors["inner"].camera.parameters
    )
    assert _surprise(answer, scene) < MOST_SURPRISE


def test_sensor_without_a_picture_is_refused_by_name(scene, told, rng):
    showings = _showings(scene, rng, 4, sensors=["inner"])
    with pytest.raises(TooFewViews, match="'outer' has no usable picture"):
        _solved(showings, told, scene)


def test_unknown_names_are_refused(scene, told, rng):
    showings = _showings(scene, rng, 3)
    with pytest.raises(ValueError, match="anchor 'upper'"):
        _solved(showings, told, scene, "upper")
    board, view = showings[0].views["inner"]
    with pytest.raises(ValueError, match="sensor 'upper'"):
        _solved([RigShowing("odd", {"upper": (board, view)})], told, scene)
    with pytest.raises(ValueError, match="board 'third'"):
        _solved([RigShowing("odd", {"inner": ("third", view)})], told, scene)
    with pytest.raises(ValueError, match="a name each"):
        _solved([showings[0], showings[0]], told, scene)
