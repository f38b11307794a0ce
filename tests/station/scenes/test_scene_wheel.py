"""Does the picture of a wheel show its true section?  Without noise; measuring it is elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from station.scenes import (
    Light,
    WheelScene,
    WheelTruth,
    projector_in_cam_mm,
    trackside_mounting,
)
from station.scenes.patch import Window
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet
from station.scenes.steel import returned
from station.scenes.wheel_light import stripe_light


def body_of(scene):
    cam_from_axle = scene.rig_from_camera.inverse() @ scene.rig_from_axle
    return Revolution(scene.wheel.profile, scene.wheel.radius_mm, cam_from_axle)


def true_section(scene):
    """Points of the section that are lit and seen, camera frame, and their places (y, z)."""
    body, source = body_of(scene), projector_in_cam_mm(scene.sensor)
    strip = body.section(scene.sensor.plane, source, np.zeros(1))
    points = strip.points_in_cam_mm[:, 0]
    shown = body.sees(points, np.zeros(3)) & body.sees(points, source)
    return points[shown], scene.wheel.profile.points_mm[strip.place[shown]]


def on_profile(scene, points_in_cam_mm):
    """Place (y, z) of points on the wheel, by their distance from the axle."""
    points = (scene.rig_from_axle.inverse() @ scene.rig_from_camera).apply(points_in_cam_mm)
    radius = np.hypot(points[:, 0], points[:, 2])
    return np.column_stack([points[:, 1], radius - scene.wheel.radius_mm])


@pytest.mark.parametrize(
    ("side", "offset_mm", "wheel"),
    [
        ("left", 0.0, WheelTruth("S1002")),
        ("left", 40.0, WheelTruth("S1002", 3.0, 2.0, radius_mm=415.0)),
        ("right", -30.0, WheelTruth("LMA", 2.0, 1.0)),
    ],
)
def test_stripe_on_the_wheel_lies_on_the_true_profile(
    sensor, clear, ridge_of, side, offset_mm, wheel
):
    scene = WheelScene(
        sensor, trackside_mounting(side), wheel, offset_mm, lateral_shift_mm=3.0, physics=clear
    )
    light = scene.light_counts() - replace(scene, laser_on=False).light_counts()
    points, places = true_section(scene)
    ridge = ridge_of(light, sensor.camera.project(points))
    seen = on_profile(scene, sensor.locate(ridge))
    distance_mm, _ = cKDTree(wheel.profile.points_mm).query(seen)
    y, z = places.T
    even = (y > -25.0) & (y < 55.0) | (y <= -70.0) & (np.abs(z + 15.0) < 20.0)
    # Tread and flange back are straight and evenly lit: measured 0.006 mm at most.
    assert distance_mm[even].max() < 0.01
    # Elsewhere the bright neighbourhood draws a centroid across a bent, dark stripe: by up to
    # 0.023 mm at the foot of the flange, 0.008 mm RMS.
    inside = y < 57.0
    assert np.sqrt(np.mean(distance_mm[inside] ** 2)) < 0.012
    assert distance_mm[inside].max() < 0.03


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("wear", [(0.0, 0.0), (3.0, 2.0)])
def test_flange_back_face_and_tread_are_all_lit_and_seen(sensor, side, wear):
    scene = WheelScene(sensor, trackside_mounting(side), WheelTruth("S1002", *wear))
    y, z = true_section(scene)[1].T
    front = scene.wheel.profile.points_mm
    front = front[(front[:, 0] > -70.0) & (front[:, 0] < 59.9)]
    assert (y > -70.0).sum() >= len(front) - 5
    assert ((y == -70.0) & (z < 9.0)).sum() * 0.05 > 40.0  # mm of back face
    light = scene.light_counts() - replace(scene, laser_on=False).light_counts()
    pixels = np.rint(sensor.camera.project(true_section(scene)[0])).astype(int)
    # Half-lit are the last pixels at either end of the stripe. The darkest of the rest still
    # stands ten times out of the noise of a dark pixel, 0.6 counts.
    within = (y < 58.0) & (z > -40.0)
    assert light[pixels[:, 1], pixels[:, 0]][within].min() > 6.0


def test_sheet_of_the_mounting_holds_the_axle_of_a_nominal_wheel(sensor):
    for side in ("left", "right"):
        rig_from_camera = trackside_mounting(side)
        axle = np.array([[0.0, -800.0, 420.0], [0.0, 800.0, 420.0]])
        in_cam = rig_from_camera.inverse().apply(axle)
        np.testing.assert_allclose(sensor.plane.distance_mm(in_cam), 0.0, atol=1e-9)


def test_right_side_is_the_mirror_picture_of_the_left(sensor):
    left, right = (trackside_mounting(side).translation_mm for side in ("left", "right"))
    np.testing.assert_allclose(right, left * [-1.0, 1.0, 1.0], atol=1e-9)
    # The camera stands between the rails and looks up to the field side.
    assert left[1] < -70.0
    assert left[2] < 0.0
    for side in ("left", "right"):
        assert trackside_mounting(side).rotation[1, 2] > 0.0


def test_unknown_side_is_refused():
    with pytest.raises(ValueError, match="left or right"):
        trackside_mounting("middle")


def test_oblique_section_is_no_radial_one_but_keeps_the_distance_from_the_axle(sensor):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth(), axle_offset_mm=50.0)
    points, places = true_section(scene)
    np.testing.assert_allclose(on_profile(scene, points), places, atol=1e-9)
    np.testing.assert_allclose(sensor.plane.distance_mm(points), 0.0, atol=1e-9)
    in_rig = scene.rig_from_camera.apply(points)
    along = np.hypot(in_rig[:, 0] - 50.0, in_rig[:, 2] - 420.0)
    # 25 mm beside the axle: the chord's foot is not the axle.
    foot = np.array([50.0 - 25.0 * 0.5, 420.0 - 25.0 * np.sqrt(0.75)])
    chord = np.hypot(in_rig[:, 0] - foot[0], in_rig[:, 2] - foot[1])
    np.testing.assert_allclose(along**2 - chord**2, 25.0**2, atol=1e-6)


def test_flange_hides_what_lies_behind_it(sensor):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth())
    body = body_of(scene)
    profile = scene.wheel.profile.points_mm
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    points = strip.points_in_cam_mm[:, 0]
    tip = int(np.argmax(profile[:, 1]))
    # From a place low over the flange's far side, the foot of the flange is hidden, the tip not.
    low_in_rig = np.array([[407.0, -400.0, 185.0]])
    eye = scene.rig_from_camera.inverse().apply(low_in_rig)[0]
    seen = body.sees(points, eye)
    assert seen[tip]
    foot = int(np.argmin(np.abs(profile[:, 0] + 33.0)))
    assert not seen[foot]


def test_first_hit_lies_on_the_wheel(sensor):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth())
    points, _ = true_section(scene)
    hits, normals = body_of(scene).first_hit(points)
    tread = np.abs(on_profile(scene, points)[:, 0] - 18.0) < 38.0
    np.testing.assert_allclose(hits[tread], points[tread], atol=0.3)
    assert ((normals * hits).sum(axis=1) < 0.0).mean() > 0.95


def test_laser_off_shows_no_stripe(sensor, rng):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth(), laser_on=False)
    assert scene.render(rng).max() < 40


def test_wheel_out_of_the_sheet_shows_no_stripe(sensor, rng):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth(), axle_offset_mm=-900.0)
    assert scene.render(rng).max() < 40


def test_stray_light_throws_a_second_stripe_on_the_wheel(sensor):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth(), light=Light.STRAY, seed=3)
    light = scene.light_counts()
    column = int(sensor.camera.project(true_section(scene)[0])[-800, 0])
    bright = light[:, column] > 200.0
    assert (np.diff(bright.astype(int)) == 1).sum() >= 2


def test_dim_light_leaves_the_wheel_dim(sensor):
    mounting = trackside_mounting("left")
    good, dim = (
        WheelScene(sensor, mounting, WheelTruth(), light=light).light_counts().max()
        for light in (Light.GOOD, Light.DIM)
    )
    assert dim < 0.4 * good


def test_the_same_seed_and_generator_give_the_same_picture(sensor):
    scene = WheelScene(sensor, trackside_mounting("right"), WheelTruth("LMA", 1.0), seed=5)
    pictures = [scene.render(np.random.default_rng(1)) for _ in range(2)]
    np.testing.assert_array_equal(*pictures)


def test_place_that_is_no_number_is_refused(sensor):
    with pytest.raises(ValueError, match="axle_offset_mm"):
        WheelScene(sensor, trackside_mounting("left"), WheelTruth(), axle_offset_mm=np.nan)


@pytest.mark.parametrize("y_mm", [-55.0, 0.0, 45.0])
def test_stripe_on_the_wheel_is_as_bright_as_light_and_steel_make_it(sensor, rng, y_mm):
    scene = WheelScene(sensor, trackside_mounting("left"), WheelTruth())
    body = body_of(scene)
    sheet = LaserSheet.of_sensor(sensor, rng, unevenness=0.0)
    clean = np.ones(len(scene.wheel.profile.points_mm))
    window = Window.whole(sensor.camera)
    light = stripe_light(body, sheet, sensor.camera, window, clean)

    strip = body.section(sensor.plane, sheet.source_in_cam_mm, np.zeros(1))
    place = int(np.argmin(np.abs(scene.wheel.profile.points_mm[strip.place, 0] - y_mm)))
    point, normal = strip.points_in_cam_mm[place], strip.normals_in_cam[place]
    to_light = sheet.source_in_cam_mm - point
    share = returned(
        np.array([y_mm]),
        normal,
        to_light / np.linalg.norm(to_light),
        -point / np.linalg.norm(point),
    )
    expected = float(sheet.irradiance(point, normal)[0] * share[0])
    u, v = np.rint(sensor.camera.project(point)[0]).astype(int)
    # Sharing the light out over four pixels widens a stripe of 1.2 px so that its height falls
    # to 0.95; the brightest pixel misses the middle of the stripe by up to half a pixel: 0.92.
    assert 0.84 * expected < light[v - 3 : v + 4, u].max() < 1.03 * expected
