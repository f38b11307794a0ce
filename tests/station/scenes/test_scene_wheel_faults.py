"""What dirt, polish and sunlight do to a picture of a wheel, and a rail in place of one.

Without noise; measuring such wheels is elsewhere.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from station.scenes import (
    RailScene,
    Soiling,
    WheelFaults,
    WheelScene,
    WheelTruth,
    projector_in_cam_mm,
    trackside_mounting,
)
from station.scenes.double_reflection import mirrored_stripe
from station.scenes.patch import Window
from station.scenes.rail_scene import rail_head
from station.scenes.revolution import Revolution
from station.scenes.sheet import LaserSheet
from station.scenes.sun_stripe import sun_through_slit

PROFILE = WheelTruth("S1002").profile
POINTS = PROFILE.points_mm


def scene_of(sensor, **changes):
    return WheelScene(sensor, trackside_mounting("left"), WheelTruth("S1002"), seed=2, **changes)


def body_of(scene):
    cam_from_axle = scene.rig_from_camera.inverse() @ scene.rig_from_axle
    return Revolution(scene.wheel.profile, scene.wheel.radius_mm, cam_from_axle)


def test_clean_rim_bears_nothing(rng):
    coat = Soiling().coat(POINTS, rng)
    assert (coat.returns == 1.0).all()
    assert (coat.height_mm == 0.0).all()


def test_gaps_are_dark_and_of_their_size(rng):
    dark = Soiling(gaps=1).coat(POINTS, rng).returns < 0.5
    # 1.5 to 5 mm of profile, points 0.05 mm apart.
    assert 1.4 <= 0.05 * dark.sum() <= 5.1


def test_lumps_stand_on_the_steel_and_are_drawn_where_they_stand(sensor, rng, clear, ridge_of):
    soiling = Soiling(lumps=3)
    coat = soiling.coat(POINTS, np.random.default_rng([2, 1]))
    assert 0.3 <= coat.height_mm.max() <= 3 * 1.2
    plain = scene_of(sensor, physics=clear)
    lumpy = replace(plain, faults=WheelFaults(soiling=soiling))
    light = lumpy.light_counts() - replace(lumpy, laser_on=False).light_counts()
    surface = replace(
        plain.wheel.profile, points_mm=POINTS + coat.height_mm[:, None] * PROFILE.normals
    )
    body = replace(body_of(plain), profile=surface)
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    on_tread = np.abs(surface.points_mm[strip.place, 0] - 18.0) < 36.0
    pixels = sensor.camera.project(strip.points_in_cam_mm[on_tread, 0])[::6]
    seen = sensor.locate(ridge_of(light, pixels))
    off = cKDTree(strip.points_in_cam_mm[:, 0]).query(seen)[0]
    # Only at the corners of a lump 2 mm wide is a centroid drawn aside, by up to 0.3 mm.
    assert np.median(off) < 0.02
    assert np.percentile(off, 90) < 0.1


def test_grease_takes_light_from_the_flange_face_and_rust_adds_it_beyond_the_rolled_band(rng):
    y = POINTS[:, 0]
    coat = Soiling(grease=0.9, rust=2.0).coat(POINTS, rng)
    assert coat.returns[(y > -44.0) & (y < -27.0)] == pytest.approx(0.1, abs=0.01)
    assert coat.returns[(y > 42.0) & (y < 59.0)] == pytest.approx(3.0, abs=0.01)
    assert coat.returns[np.abs(y) < 15.0] == pytest.approx(1.0, abs=0.01)


def test_burnish_makes_one_profile_clip_and_stay_dark_at_once(sensor, rng):
    bright = scene_of(sensor, faults=WheelFaults(soiling=Soiling(burnish=8.0)))
    picture = bright.render(rng)
    assert (picture == 255).sum() > 500
    strip = body_of(bright).section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    back = POINTS[strip.place, 0] == -70.0
    u, v = np.rint(sensor.camera.project(strip.points_in_cam_mm[back, 0])[-500]).astype(int)
    assert picture[v, u - 4 : u + 5].max() < 60


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"gaps": 13}, "gaps"),
        ({"lumps": -1}, "lumps"),
        ({"grease": 1.0}, "grease"),
        ({"rust": np.nan}, "rust"),
        ({"burnish": -0.1}, "burnish"),
    ],
)
def test_soiling_out_of_range_is_refused(change, match):
    with pytest.raises(ValueError, match=match):
        Soiling(**change)


@pytest.mark.parametrize(("name", "value"), [("mirror_share", 1.5), ("sun_stripe", -1.0)])
def test_faults_out_of_range_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        WheelFaults(**{name: value})


@pytest.fixture(scope="module")
def mirrored(sensor):
    """Only what the polished steel shows, and the body."""
    scene = scene_of(sensor)
    body = body_of(scene)
    sheet = LaserSheet.of_sensor(sensor, np.random.default_rng(1), unevenness=0.0)
    window = Window.whole(sensor.camera)
    return mirrored_stripe(body, sheet, sensor.camera, window, 0.3), body


def test_mirrored_stripe_is_where_the_law_of_reflection_puts_it(sensor, mirrored):
    light, body = mirrored
    v, u = np.unravel_index(np.argsort(light.ravel())[-200:], light.shape)
    rays = sensor.camera.rays(np.column_stack([u, v]).astype(np.float64))
    points, normals = body.first_hit(rays)
    sight = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    onward = sight - 2.0 * np.sum(sight * normals, axis=1, keepdims=True) * normals
    # Along the mirrored sight, how near does it come to the lit line of the wheel?
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    way = points[:, None] + np.arange(1.0, 90.0, 0.25)[:, None] * onward[:, None]
    nearest = cKDTree(strip.points_in_cam_mm[:, 0]).query(way)[0].min(axis=1)
    # The mirror smears by 0.6 mm, a pixel is 0.3 mm, and a pixel's error in the throat's normal
    # (R 13 mm) turns the sight by 0.04 over 20 mm.
    assert np.median(nearest) < 0.8
    assert np.percentile(nearest, 90) < 2.0


def test_mirrored_stripe_is_fainter_than_the_stripe_and_beside_it(sensor, mirrored):
    light, body = mirrored
    assert 0.0 < light.max() < 0.3
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    pixels = sensor.camera.project(strip.points_in_cam_mm[:, 0])
    v, u = np.nonzero(light > 0.3 * light.max())
    apart = cKDTree(pixels).query(np.column_stack([u, v]))[0]
    assert np.median(apart) > 8.0


def test_light_from_the_tread_meets_the_flange_or_the_air(sensor):
    body = body_of(scene_of(sensor))
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    tread = np.flatnonzero(np.abs(POINTS[strip.place, 0] + 10.0) < 2.0)
    points, normals = strip.points_in_cam_mm[tread, 0], strip.normals_in_cam[tread, 0]
    lateral = body.cam_from_axle.rotation[:, 1]
    low = -lateral + 0.2 * normals
    low /= np.linalg.norm(low, axis=1, keepdims=True)
    met, _ = body.next_hit(points, low)
    y = body.cam_from_axle.inverse().apply(met)[:, 1]
    assert ((y > -45.0) & (y < -30.0)).all()
    assert np.isnan(body.next_hit(points, normals)[0]).all()


def test_sun_through_a_slit_draws_a_stripe_of_its_brightness_beside_the_lasers(sensor, rng):
    body = body_of(scene_of(sensor))
    laser = LaserSheet.of_sensor(sensor, rng, unevenness=0.0)
    sun = sun_through_slit(body, laser, rng, power=0.5)
    strip = body.section(sun.plane, sun.source_in_cam_mm, np.zeros(1))
    y = POINTS[strip.place, 0]
    tread = np.abs(y - 10.0) < 20.0
    points = strip.points_in_cam_mm[tread, 0]
    facing = sun.source_in_cam_mm - points
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    # The sun is as bright everywhere, to the softness of the fan.
    assert sun.irradiance(points, facing) == pytest.approx(0.5, rel=0.02)
    apart = np.abs(sensor.plane.distance_mm(points))
    assert (apart > 5.0).all()
    assert (apart < 40.0).all()


def test_neighbour_is_a_second_wheel_so_far_aside(sensor):
    alone = scene_of(sensor, lateral_shift_mm=-80.0)
    both = replace(alone, neighbours_mm=(160.0,))
    extra = both.light_counts() - alone.light_counts()
    there = replace(alone, lateral_shift_mm=80.0)
    strip = body_of(there).section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    tread = np.abs(POINTS[strip.place, 0]) < 20.0
    pixels = np.rint(sensor.camera.project(strip.points_in_cam_mm[tread, 0])).astype(int)
    assert (extra[pixels[:, 1], pixels[:, 0]] > 30.0).mean() > 0.95


def test_stripe_on_a_rail_lies_on_its_head(sensor, clear, ridge_of):
    scene = RailScene(sensor, trackside_mounting("left"), physics=clear)
    body = Revolution(rail_head(), 1e5, scene._cam_from_axle())
    strip = body.section(sensor.plane, projector_in_cam_mm(sensor), np.zeros(1))
    crown = np.abs(rail_head().points_mm[strip.place, 0]) < 20.0
    points = strip.points_in_cam_mm[crown, 0]
    light = scene.light_counts()
    seen = sensor.locate(ridge_of(light, sensor.camera.project(points)[::6]))
    # The crown is nearly flat: nothing draws a centroid aside.
    assert cKDTree(points).query(seen)[0].max() < 0.05
    width = np.ptp(points @ body.cam_from_axle.rotation[:, 1])
    assert width == pytest.approx(40.0, abs=0.2)
