"""Can a rigid target be calibrated from as it is shown, and are its dots where they are printed?"""

from dataclasses import replace

import numpy as np
import pytest

from calib import RigidTransform, Target, observe_target
from station.scenes import (
    Light,
    MountedBoard,
    RigidTarget,
    TargetScene,
    WheelRig,
    projector_in_cam_mm,
    rig_showings,
    target_poses,
)
from station.scenes.crossing import crossing_on_board
from station.scenes.placed_board import PlacedBoard
from station.scenes.showings import crosses_rectangle

COUNT = 12


@pytest.fixture(scope="module", params=["left", "right"])
def shown(request, target):
    """A rig as built, a target for it, and twelve showings."""
    rng = np.random.default_rng(12)
    rig = WheelRig.trackside(request.param).as_built(rng)
    body = RigidTarget.board_each(rng, rig.sensors, target, printing_sigma_mm=0.02)
    return rig, body, rig_showings(rng, rig.sensors, body, [Light.GOOD] * COUNT)


def test_every_board_is_in_view_and_crossed_by_its_own_sheet(shown, target):
    rig, _, showings = shown
    middle = target.points_mm[:, :2].mean(axis=0)
    for showing in showings:
        for each in rig.sensors:
            pose = showing.scenes[each.name].cam_from_board
            pixels = each.sensor.camera.project(pose.apply(target.points_mm))
            assert pixels.min() > 20.0
            assert (pixels < np.array([2048.0, 1088.0]) - 20.0).all()
            crossing = crossing_on_board(each.sensor.plane, pose, middle)
            slope = crossing.direction[1] / crossing.direction[0]
            ends = crossing.nearest_mm[1] + slope * ([0.0, 84.0] - crossing.nearest_mm[0])
            assert ((ends >= 0.0) & (ends <= 72.0)).all()


def test_boards_are_rigid_and_stand_where_the_body_is(shown):
    rig, body, showings = shown
    for showing in showings:
        for each in rig.sensors:
            by_camera = each.rig_from_camera @ showing.scenes[each.name].cam_from_board
            by_body = showing.rig_from_body @ body.boards[each.name].body_from_board
            np.testing.assert_allclose(by_camera.rotation, by_body.rotation, atol=1e-12)
            np.testing.assert_allclose(by_camera.translation_mm, by_body.translation_mm, atol=1e-9)
    first, second = (body.boards[name].body_from_board for name in rig.exact.names)
    np.testing.assert_array_equal(first.rotation, np.eye(3))
    # A roof whose sides face cameras that look from 70 degrees apart, one sheet 15 from the other.
    assert 50.0 < np.degrees(np.linalg.norm(second.rotation_vector)) < 90.0


def test_turns_go_about_several_axes(shown):
    _, body, showings = shown
    turns = np.degrees([
        (showing.rig_from_body @ body.resting.inverse()).rotation_vector for showing in showings
    ])
    angles = np.linalg.norm(turns, axis=1)
    assert angles.min() > 15.0 - 1e-6
    assert angles.max() < 35.0 + 1e-6
    # About each axis alike it would be 15 degrees; the draw of 12 leaves a fifth of that.
    assert turns.std(axis=0).min() > 6.0


def test_no_board_stands_before_another(rng):
    # Broad boards before coplanar sheets touch nearly; some poses must be thrown away for it.
    angle, target = np.radians(30.0), Target.parse("dots:7x10:12:d=6")
    rig = WheelRig.trackside("right", below_horizon_rad={"inner": angle}).as_built(rng)
    body = RigidTarget.board_each(rng, rig.sensors, target)
    inner, outer = (body.boards[name] for name in rig.exact.names)
    for showing in rig_showings(rng, rig.sensors, body, [Light.GOOD] * 40):
        for own, other, each in zip((inner, outer), (outer, inner), rig.sensors, strict=True):
            body_from_camera = showing.rig_from_body.inverse() @ each.rig_from_camera
            eyes = body_from_camera.apply(np.array([np.zeros(3), projector_in_cam_mm(each.sensor)]))
            points = own.body_from_board.apply(own.target.points_mm)
            for eye in eyes:
                assert not crosses_rectangle(other.corners_mm, eye, points).any()


def test_other_boards_are_in_the_picture_dark_unless_all_are_lit(target, rng):
    rig = WheelRig.trackside("left").as_built(rng)
    kinds = (target, Target.parse("dots:6x9:12:d=6"))
    body = RigidTarget.board_each(rng, rig.sensors, kinds)
    seed = rng.integers(2**32)
    for all_lit in (False, True):
        (showing,) = rig_showings(
            np.random.default_rng(seed), rig.sensors, body, [Light.GOOD], all_lit=all_lit
        )
        scene = showing.scenes["inner"]
        (other,) = scene.beside
        assert other.target == kinds[1]
        pixels = scene.sensor.camera.project(other.cam_from_board.apply(other.target.points_mm))
        u, v = np.rint(pixels).astype(int).T
        inside = (u >= 0) & (u < 2048) & (v >= 0) & (v < 1088)
        assert inside.sum() > 20
        level = np.median(scene.light_counts()[v[inside], u[inside]])
        assert (level > 80.0) if all_lit else (level < 20.0)
    for name, kind in zip(rig.exact.names, kinds, strict=True):
        scene = showing.scenes[name]
        view = observe_target(scene.render(rng), kind, name=name)
        of_view = view.points.row * kind.cols + view.points.col
        places = scene.sensor.camera.project(scene.cam_from_board.apply(kind.points_mm))[of_view]
        # The pictures of the dots' centres differ from those of the dots by 0.1 px.
        assert np.abs(view.points.centre_px - places).max() < 1.0
        assert len(of_view) > 50


@pytest.mark.parametrize(("aslant_deg", "drawn"), [(85.0, True), (95.0, False), (97.5, False)])
def test_board_beside_is_drawn_unless_it_is_seen_edge_on(sensor, target, aslant_deg, drawn):
    # Turned by 97.67 degrees its plane goes through the camera, and rays meet it nowhere.
    pose = RigidTransform(np.eye(3), np.array([-40.0, -36.0, 500.0]))
    turn = RigidTransform.from_rotation_vector([0.0, np.radians(aslant_deg), 0.0], np.zeros(3))
    beside = PlacedBoard(target, RigidTransform(turn.rotation, np.array([70.0, -36.0, 520.0])))
    assert beside.shows_its_front
    alone = TargetScene(sensor, target, pose)
    light = replace(alone, beside=(beside,)).light_counts()
    assert np.isfinite(light).all()
    assert (light != alone.light_counts()).any() == drawn


def test_way_through_a_rectangle_is_told_from_one_that_ends_before_it_or_passes_by():
    corners = np.array([[0.0, 0.0, 10.0], [4.0, 0.0, 10.0], [4.0, 2.0, 10.0], [0.0, 2.0, 10.0]])
    eye = np.array([1.0, 1.0, 0.0])
    ends = np.array([[1.0, 1.0, 20.0], [1.0, 1.0, 9.0], [11.0, 1.0, 20.0], [1.0, 1.0, -20.0]])
    np.testing.assert_array_equal(
        crosses_rectangle(corners, eye, ends), [True, False, False, False]
    )


def test_shared_board_is_shown_to_coplanar_sensors(target, rng):
    angle = np.radians(30.0)
    rig = WheelRig.trackside("left", below_horizon_rad={"inner": angle}).as_built(rng)
    body = RigidTarget.shared_board(rng, rig.sensors, target)
    assert body.boards["inner"] is body.boards["outer"]
    showings = rig_showings(rng, rig.sensors, body, [Light.GOOD] * 4)
    for showing in showings:
        places = [
            each.rig_from_camera @ showing.scenes[each.name].cam_from_board for each in rig.sensors
        ]
        np.testing.assert_allclose(places[0].translation_mm, places[1].translation_mm, atol=1e-9)


def test_target_that_no_pose_suits_is_refused(target, rng):
    rig = WheelRig.trackside("left")
    with pytest.raises(ValueError, match="smaller boards"):
        rig_showings(rng, rig.sensors, RigidTarget.shared_board(rng, rig.sensors, target), ["good"])


@pytest.mark.parametrize("spec", ["dots:7x8:12:d=6", "dots:7x8:12:dark:d=6"])
def test_observed_dots_move_with_the_printing_errors_one_to_one(sensor, rng, spec):
    target = Target.parse(spec)
    (pose,) = target_poses(rng, 1, sensor, target)
    exact = TargetScene(sensor, target, pose, Light.GOOD, laser_on=False, seed=3)
    shift_mm = rng.normal(0.0, 0.05, (56, 2))
    places = []
    for scene in (exact, replace(exact, dot_shift_mm=shift_mm)):
        dots = observe_target(scene.render(np.random.default_rng(2)), target, name="b").points
        order = np.argsort(dots.row * target.cols + dots.col)
        assert len(order) == 56
        places.append(dots.centre_px[order])
    printed = target.points_mm + np.column_stack([shift_mm, np.zeros(56)])
    camera = sensor.camera
    expected = camera.project(pose.apply(printed)) - camera.project(pose.apply(target.points_mm))
    moved = places[1] - places[0]
    slope = (moved * expected).sum() / (expected**2).sum()
    # Shifts of 0.05 mm are 0.22 px. Noise of 0.005 px in each of two pictures, over 112 figures,
    # leaves 0.003 of the slope and 0.007 px.
    assert slope == pytest.approx(1.0, abs=0.015)
    assert np.std(moved - expected) < 0.015


def test_dots_displaced_by_nothing_are_the_dots_of_the_target(sensor, target, rng):
    (pose,) = target_poses(rng, 1, sensor, target)
    exact = TargetScene(sensor, target, pose)
    still = replace(exact, dot_shift_mm=np.zeros((56, 2)))
    np.testing.assert_array_equal(exact.light_counts(), still.light_counts())


@pytest.mark.parametrize(
    ("spec", "shift_mm", "says"),
    [
        ("dots:7x8:12:d=6", np.full((56, 2), 3.5), "less than 3"),
        ("dots:7x8:12:d=6", np.zeros((55, 2)), "dot_shift_mm"),
        ("dots:7x8:12:d=6", np.full((56, 2), np.nan), "dot_shift_mm"),
        ("chessboard:7x8:12", np.zeros((56, 2)), "only dots"),
    ],
)
def test_displacements_that_cannot_be_printed_are_refused(sensor, spec, shift_mm, says):
    target, pose = Target.parse(spec), RigidTransform(np.eye(3), np.array([0.0, 0.0, 500.0]))
    with pytest.raises(ValueError, match=says):
        TargetScene(sensor, target, pose, dot_shift_mm=shift_mm)
    with pytest.raises(ValueError, match=says):
        MountedBoard(target, RigidTransform.identity(), shift_mm)


def test_rigid_target_without_a_board_is_refused():
    with pytest.raises(ValueError, match="board at least"):
        RigidTarget({}, RigidTransform.identity())
