"""Does each sensor of a rig see its own part of a wheel, and nothing that the flange hides?"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from calib import locate_stripe
from station.scenes import (
    Light,
    WheelRig,
    WheelScene,
    WheelTruth,
    projector_in_cam_mm,
    trackside_mounting,
)
from station.scenes.revolution import Revolution

PLACES = ("inner", "outer")
SIDES = ("left", "right")


def body_of(scene):
    cam_from_axle = scene.rig_from_camera.inverse() @ scene.rig_from_axle
    return Revolution(scene.wheel.profile, scene.wheel.radius_mm, cam_from_axle)


def section_in_cam(scene, sheet_of=None):
    """The whole section, hidden or not: points in the camera frame and places (d, z)."""
    other = sheet_of or scene
    change = scene.rig_from_camera.inverse() @ other.rig_from_camera
    body = body_of(other)
    source = projector_in_cam_mm(other.sensor)
    strip = body.section(other.sensor.plane, source, np.zeros(1))
    places = scene.wheel.profile.points_mm[strip.place] + [70.0, 0.0]
    return change.apply(strip.points_in_cam_mm[:, 0]), places


def seen_places(scene, picture):
    """Places (d, z) of the stripe points of a picture, by the true sensor and pose."""
    points = scene.sensor.locate(locate_stripe(picture).centre_px)
    points = (scene.rig_from_axle.inverse() @ scene.rig_from_camera).apply(points)
    z = np.hypot(points[:, 0], points[:, 2]) - scene.wheel.radius_mm
    return np.column_stack([points[:, 1] + 70.0, z])


@pytest.fixture(scope="module")
def rig():
    return WheelRig.trackside("left").as_built(np.random.default_rng(3))


@pytest.fixture(scope="module")
def seen(rig):
    """Where the points that each sensor finds lie on a worn wheel, by name, (d, z)."""
    wheel = WheelTruth("S1002", 3.0, 2.0, radius_mm=423.0)
    shot = rig.shot(wheel, axle_offset_mm=12.0, lateral_shift_mm=2.0, seed=5)
    return {
        name: (scene, seen_places(scene, scene.render(np.random.default_rng(1))))
        for name, scene in shot.items()
    }


def test_points_of_both_lie_on_the_true_profile(seen):
    for scene, places in seen.values():
        outline = scene.wheel.profile.points_mm + [70.0, 0.0]
        off_mm, _ = cKDTree(outline).query(places)
        # Measured: 0.04 mm RMS; a point or two at the edges of shadows are up to 2 mm off.
        assert np.percentile(off_mm, 95.0) < 0.15
        assert (off_mm > 0.5).mean() < 0.02


def test_inner_sensor_sees_back_tip_and_tape_circle_and_no_flange_face(seen):
    _, places = seen["inner"]
    d, z = places.T
    back = z[np.abs(d) < 0.5]
    assert back.max() - back.min() > 40.0
    for start in (5.0, 10.0, 15.0, 55.0, 65.0, 70.0, 75.0, 100.0):
        assert ((d > start) & (d < start + 5.0)).sum() > 5
    # A line of sight over the tip at 45 degrees to the radius touches it 25 mm from the back and
    # comes down on the tread 48 mm from it.
    assert not ((d > 28.0) & (d < 46.0)).any()


def test_outer_sensor_sees_tip_face_and_tread_and_no_flange_back(seen):
    _, places = seen["outer"]
    d, _ = places.T
    for start in range(10, 125, 5):
        assert ((d > start) & (d < start + 5.0)).sum() > 5
    assert d.min() > 2.0


def test_both_see_the_flange_tip(seen):
    for _, places in seen.values():
        assert ((places[:, 0] > 10.0) & (places[:, 0] < 20.0)).sum() > 20


@pytest.mark.parametrize("side", SIDES)
def test_sheets_hold_the_axle_and_are_coplanar_only_on_demand(sensor, side):
    axle = np.array([[0.0, -800.0, 420.0], [0.0, 800.0, 420.0]])
    normals = {}
    for angle in (None, np.radians(30.0)):
        for place in PLACES:
            pose = trackside_mounting(side, place, below_horizon_rad=angle)
            in_cam = pose.inverse().apply(axle)
            np.testing.assert_allclose(sensor.plane.distance_mm(in_cam), 0.0, atol=1e-9)
            normals[angle, place] = pose.rotation @ sensor.plane.normal_in_cam
        cosine = normals[angle, "inner"] @ normals[angle, "outer"]
        between_deg = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        assert between_deg == pytest.approx(15.0 if angle is None else 0.0, abs=1e-5)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("place", PLACES)
def test_bodies_stand_below_the_rails_top_and_its_head_is_in_no_line_of_sight(sensor, side, place):
    pose = trackside_mounting(side, place)
    scene = WheelScene(sensor, pose, WheelTruth())
    points, _ = section_in_cam(scene)
    laser = projector_in_cam_mm(sensor)
    body = body_of(scene)
    shown = body.sees(points, np.zeros(3)) & body.sees(points, laser)
    for eye in (np.zeros(3), laser):
        eye_mm = pose.apply(eye[None])[0]
        assert eye_mm[2] < 0.0
        # Clear of the rail, whose foot is 150 mm wide, and on its own side of it.
        assert eye_mm[1] * (1.0 if place == "outer" else -1.0) > 150.0
        ways = np.linspace(0.0, 1.0, 300)[:, None, None]
        sight = eye_mm + ways * (pose.apply(points[shown]) - eye_mm)
        beside = np.maximum(np.abs(sight[..., 1]) - 36.5, 0.0)
        assert np.hypot(beside, np.maximum(sight[..., 2], 0.0)).min() > 10.0


def test_place_and_angle_that_there_are_not_are_refused():
    with pytest.raises(ValueError, match="only, inner, outer"):
        trackside_mounting("left", "middle")
    with pytest.raises(ValueError, match="right angle"):
        trackside_mounting("left", "inner", below_horizon_rad=np.nan)


def test_rig_as_built_is_near_its_design_and_drawn_by_its_generator():
    design = WheelRig.trackside("right", prefix="right-")
    built, again = (design.as_built(np.random.default_rng(8)) for _ in range(2))
    assert built.exact.names == ("right-inner", "right-outer")
    for wanted, has, same in zip(design.sensors, built.sensors, again.sensors, strict=True):
        np.testing.assert_array_equal(has.rig_from_camera.rotation, same.rig_from_camera.rotation)
        move = has.rig_from_camera @ wanted.rig_from_camera.inverse()
        # Five standard deviations of 5 mrad about each of three axes.
        assert 0.0 < np.linalg.norm(move.rotation_vector) < 5.0 * 5e-3 * np.sqrt(3.0)
        cosine = has.sensor.plane.normal_in_cam @ wanted.sensor.plane.normal_in_cam
        assert 0.0 < np.arccos(cosine) < 5.0 * 4e-3 * np.sqrt(3.0)


def test_vibration_shifts_one_sensor_and_is_unknown_to_the_rig(rig):
    wheel, shift_mm = WheelTruth(), np.array([0.1, -0.2, 0.3])
    still = rig.shot(wheel)
    shaken = rig.shot(wheel, vibration_mm={"outer": shift_mm})
    for name in PLACES:
        moved_mm = (
            shaken[name].rig_from_camera.translation_mm - still[name].rig_from_camera.translation_mm
        )
        np.testing.assert_allclose(moved_mm, shift_mm if name == "outer" else 0.0, atol=1e-12)
        np.testing.assert_array_equal(
            still[name].rig_from_camera.translation_mm,
            rig.exact[name].rig_from_camera.translation_mm,
        )
    with pytest.raises(ValueError, match="'middle'"):
        rig.shot(wheel, vibration_mm={"middle": shift_mm})


def test_cameras_of_a_shot_share_the_dirt_and_nothing_else(rig):
    shot = rig.shot(WheelTruth(), seed=4)
    assert len({scene.seed for scene in shot.values()}) == len(PLACES)
    assert {scene.soil_seed for scene in shot.values()} == {4}


def test_laser_of_the_other_sensor_shows_on_demand_where_its_own_section_is(rig):
    wheel = WheelTruth()
    dark = {name: replace(scene, laser_on=False) for name, scene in rig.shot(wheel).items()}
    let_in = rig.shot(wheel, others_share=0.4)
    strict = rig.shot(wheel)
    own, other = let_in["outer"], let_in["inner"]
    points, places = section_in_cam(own, sheet_of=other)
    pixels = np.rint(own.sensor.camera.project(points)).astype(int)
    tread = (places[:, 0] > 80.0) & (places[:, 0] < 120.0)
    at = pixels[tread, 1], pixels[tread, 0]
    background = dark["outer"].light_counts()[at]
    assert (own.light_counts()[at] - background).min() > 10.0
    # What is left is the flare of its own stripe.
    assert (strict["outer"].light_counts()[at] - background).max() < 2.0


def test_light_is_the_same_for_all_sensors(rig):
    shot = rig.shot(WheelTruth(), light=Light.DIM)
    assert {scene.light for scene in shot.values()} == {Light.DIM}
