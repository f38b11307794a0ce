"""Do lens, laser sheet and textures keep their promises, apart from any scene?"""

import numpy as np
import pytest

from calib import LightPlane
from station.scenes import Lens, Physics, projector_in_cam_mm
from station.scenes.sheet import LaserSheet
from station.scenes.texture import brushed, clouds, speckle


def spot(size=129):
    light = np.zeros((size, size), dtype=np.float32)
    light[size // 2, size // 2] = 1000.0
    return light


def variance_px2(light):
    rows = np.arange(len(light)) - len(light) // 2
    return float((light.sum(axis=1) * rows**2).sum() / light.sum())


@pytest.mark.parametrize("depth_mm", [400.0, 486.0, 600.0])
def test_defocus_is_that_of_a_12_mm_lens_at_f_5_6(depth_mm):
    focal_mm, pixel_mm, focus_mm = 12.7, 0.0055, 486.0
    circle_mm = focal_mm / 5.6 * focal_mm / (focus_mm - focal_mm) * abs(1.0 - focus_mm / depth_mm)
    # An even disc of diameter c has the standard deviation c / 4 along any direction.
    expected = np.hypot(0.85, circle_mm / pixel_mm / 4.0)
    sigma = Lens().blur_sigma_px(np.array([depth_mm], dtype=np.float32))[0]
    assert sigma == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("depth_mm", [400.0, 486.0, 600.0])
def test_blur_has_the_spread_of_the_depth_and_loses_no_light(depth_mm):
    lens = Lens()
    depth = np.full((129, 129), depth_mm, dtype=np.float32)
    blurred = lens.blur(spot(), depth)
    assert blurred.sum() == pytest.approx(1000.0, rel=1e-5)
    # The kernel is sampled and cut off at four sigma: 1 % of its variance.
    expected = float(lens.blur_sigma_px(depth[:1, :1])[0, 0]) ** 2
    assert variance_px2(blurred) == pytest.approx(expected, rel=0.01)


def test_blur_between_two_depths_has_the_variance_between():
    lens = Lens()
    depth = np.tile(np.linspace(400.0, 560.0, 129, dtype=np.float32), (129, 1))
    blurred = lens.blur(spot(), depth)
    expected = float(lens.blur_sigma_px(depth[:1, 64:65])[0, 0]) ** 2
    # The depth differs by 1 % over the spot's own width.
    assert variance_px2(blurred) == pytest.approx(expected, rel=0.03)


def test_flare_moves_light_from_the_middle_into_a_halo(sensor):
    light = np.zeros((sensor.camera.height, sensor.camera.width), dtype=np.float32)
    light[540:548, 1000:1008] = 200.0
    lens = Lens(corner=0.0)
    seen = lens.finish(light, sensor.camera)
    assert seen.sum() == pytest.approx(light.sum(), rel=0.01)
    assert seen[544, 1004] == pytest.approx(200.0 * (1.0 - sum(lens.flare)), rel=0.01)
    assert seen[544, 1040] > 0.0


def test_corners_lose_their_share_of_light(sensor):
    light = np.full((sensor.camera.height, sensor.camera.width), 100.0, dtype=np.float32)
    lens = Lens(flare=(0.0, 0.0))
    seen = lens.finish(light, sensor.camera)
    assert seen[555, 1005] == pytest.approx(100.0, rel=1e-4)
    # The principal point is not quite in the middle, so the corners differ by a few parts.
    corners = seen[[0, 0, -1, -1], [0, -1, 0, -1]]
    assert corners.mean() == pytest.approx(100.0 * (1.0 - lens.corner), rel=0.01)


def test_speckle_has_its_contrast_mean_one_and_grains_of_its_size(rng):
    factor = speckle(rng, (400, 400), 0.1, grain_px=0.8)
    # About 32000 independent grains: the standard deviation is pinned to 0.4 %.
    assert factor.std() == pytest.approx(0.1, rel=0.03)
    assert factor.mean() == pytest.approx(1.0, abs=0.003)
    centred = factor - factor.mean()
    neighbours = (centred[:, 1:] * centred[:, :-1]).mean() / centred.var()
    # A Gaussian of sigma g gives neighbours the correlation exp(-1 / (4 g^2)) = 0.68.
    assert neighbours == pytest.approx(np.exp(-1.0 / (4.0 * 0.8**2)), abs=0.03)


def test_no_speckle_leaves_the_light_as_it_is(rng):
    assert (speckle(rng, (8, 8), 0.0) == 1.0).all()


@pytest.mark.parametrize("texture", [brushed, lambda rng, shape: clouds(rng, shape, 32.0)])
def test_textures_have_mean_zero_and_deviation_one(rng, texture):
    field = texture(rng, (120, 90))
    assert field.mean() == pytest.approx(0.0, abs=1e-4)
    assert field.std() == pytest.approx(1.0, abs=1e-3)


def test_sheet_is_gaussian_across_and_brightest_square_to_the_light(sensor, rng):
    sheet = LaserSheet.of_sensor(sensor, rng, unevenness=0.0)
    aim = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))
    across = np.linspace(-1.0, 1.0, 201)[:, None] * sensor.plane.normal_in_cam
    light = sheet.irradiance(aim + across, -sheet.axis_in_cam)
    q_mm = np.linspace(-1.0, 1.0, 201)
    sigma_mm = np.sqrt((light * q_mm**2).sum() / light.sum())
    # The thickness swells by up to a tenth along the fan.
    assert sigma_mm == pytest.approx(sheet.sigma_mm, rel=0.11)
    # The sheet's middle is 593 mm from the laser within 0.5 mm.
    assert light.max() == pytest.approx(1.0, rel=2e-3)
    assert np.argmax(light) == 100


def test_sheet_leaves_surfaces_that_face_away_dark(sensor, rng):
    sheet = LaserSheet.of_sensor(sensor, rng, unevenness=0.1)
    aim = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))
    assert sheet.irradiance(aim, sheet.axis_in_cam)[0] == 0.0


def test_brightness_falls_with_distance_and_incidence(sensor, rng):
    sheet = LaserSheet.of_sensor(sensor, rng, unevenness=0.0)
    source = projector_in_cam_mm(sensor)
    points = source + np.array([[400.0], [800.0]]) * sheet.axis_in_cam
    near, far = sheet.irradiance(points, -sheet.axis_in_cam)
    assert near / far == pytest.approx(2.0)
    slanted = -sheet.axis_in_cam * 0.5 + sensor.plane.normal_in_cam * np.sqrt(0.75)
    assert sheet.irradiance(points[:1], slanted)[0] / near == pytest.approx(0.5)


def test_unevenness_is_the_deviation_along_the_fan(sensor):
    deviations = []
    for seed in range(40):
        sheet = LaserSheet.of_sensor(sensor, np.random.default_rng(seed), unevenness=0.1)
        across = np.cross(sheet.plane.normal_in_cam, sheet.axis_in_cam)
        angle = np.linspace(-0.2, 0.2, 200)[:, None]
        beams = np.cos(angle) * sheet.axis_in_cam + np.sin(angle) * across
        light = sheet.irradiance(sheet.source_in_cam_mm + 593.0 * beams, -beams)
        deviations.append(light.std())
    # Few waves over a part of the fan: single fans differ, their mean is near.
    assert np.sqrt(np.mean(np.square(deviations))) == pytest.approx(0.1, rel=0.2)


def test_source_beside_the_sheet_is_refused():
    with pytest.raises(ValueError, match="source_in_cam_mm"):
        LaserSheet(
            plane=LightPlane.from_coefficients([0.0, 0.0, 1.0, -500.0]),
            source_in_cam_mm=np.zeros(3),
            axis_in_cam=np.array([1.0, 0.0, 0.0]),
            sigma_mm=0.2,
            power=1.0,
            waves=np.zeros((1, 3)),
        )


def test_impossible_roughness_is_refused():
    with pytest.raises(ValueError, match="grain"):
        Physics(grain=np.nan)
