"""Pictures of a stripe on a wheel by a second, cruder hand than the station's scenes.

It shares with them nothing but the camera: a polyline of the section gets a brightness that falls
off with the distance from it, by a law of the test's choosing, and noise of another kind. What no
lens does (flat tops, long tails, hard gaps, rows that are brighter) is there on purpose.
"""

from dataclasses import dataclass

import numpy as np
import wheel_stripes as ws
from scipy.spatial import cKDTree

REACH_PX = 14


def gaussian(r):
    return np.exp(-0.5 * (r / 1.3) ** 2)


def flat_topped(r):
    return np.exp(-((r / 2.6) ** 6))


def long_tailed(r):
    return 1.0 / (1.0 + (r / 1.4) ** 2) ** 1.5


SHAPES = {"gaussian": gaussian, "flat": flat_topped, "tailed": long_tailed}


@dataclass(frozen=True)
class Crude:
    """What a crude picture looks like; brightness in counts."""

    shape: str = "gaussian"
    counts: float = 140.0
    dark_end: float = 1.0  # share of the brightness left at the flange back
    gaps: int = 0  # hard, 2 to 4 mm of section each
    ghost: float = 0.0  # share of the brightness of a second stripe, shifted and sheared
    blobs: int = 0
    noise: float = 1.0
    rows: float = 0.0  # counts by which rows differ


def draw(wheel, sensor, rig_from_camera, look, rng):
    """Return an 8-bit picture."""
    pixels, share = _line(wheel, sensor, rig_from_camera, look, rng)
    size = np.array([sensor.camera.width, sensor.camera.height])
    light = _painted(pixels, share * look.counts, look, size)
    if look.ghost:
        middle = pixels.mean(axis=0)
        shear = np.array([[1.0, 0.0], [rng.uniform(-0.05, 0.05), 1.0]])
        aside = [0.0, rng.choice([-1.0, 1.0]) * rng.uniform(25.0, 60.0)]
        ghost = (pixels - middle) @ shear.T + middle + aside
        light += _painted(ghost, share * look.counts * look.ghost, look, size)
    v, u = np.mgrid[: size[1], : size[0]].astype(np.float32)
    for _ in range(look.blobs):
        place, sigma = rng.uniform([0.0, 0.0], size), rng.uniform(4.0, 20.0)
        light += 150.0 * np.exp(-0.5 * ((u - place[0]) ** 2 + (v - place[1]) ** 2) / sigma**2)
    light += 8.0 + look.rows * rng.normal(size=(size[1], 1))
    light += look.noise * rng.standard_normal(light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def _line(wheel, sensor, rig_from_camera, look, rng):
    """Return the section's pixels, close together, and the share of the light at each."""
    profile = wheel.points(0.02)
    points, normals = ws.section_in_rig(wheel, profile, sensor, rig_from_camera)
    camera_from_rig = rig_from_camera.inverse()
    in_cam = camera_from_rig.apply(points)
    facing = np.sum((normals @ camera_from_rig.rotation.T) * -in_cam, axis=1) > 0.0
    waves = rng.normal(size=(4, 2)) / 4.0
    along = np.linspace(0.0, 1.0, len(profile))
    share = 1.0 + 0.4 * sum(
        a * np.sin(6.0 * k * along) + b * np.cos(6.0 * k * along)
        for k, (a, b) in enumerate(waves, start=1)
    )
    share = share * np.where(profile[:, 0] < -69.9, look.dark_end, 1.0)
    for _ in range(look.gaps):
        # Not where the gauges read: there a gap costs the value, as it should.
        middle = rng.choice([-63.0, -25.0, 20.0, 33.0, 46.0])
        share[np.abs(profile[:, 0] - middle) < rng.uniform(1.0, 2.0)] = 0.0
    return sensor.camera.project(in_cam)[facing], np.clip(share, 0.0, 1.6)[facing]


def _painted(pixels, counts, look, size):
    tree = cKDTree(pixels)
    corners = np.unique(np.rint(pixels).astype(int), axis=0)
    steps = np.stack(np.mgrid[-REACH_PX : REACH_PX + 1, -REACH_PX : REACH_PX + 1], axis=-1)
    near = np.unique((corners[::4, None] + steps.reshape(1, -1, 2)).reshape(-1, 2), axis=0)
    near = near[(near >= 0).all(axis=1) & (near < size).all(axis=1)]
    distance, which = tree.query(near, distance_upper_bound=REACH_PX)
    hit = np.isfinite(distance)
    light = np.zeros((size[1], size[0]), dtype=np.float32)
    light[near[hit, 1], near[hit, 0]] = counts[which[hit]] * SHAPES[look.shape](distance[hit])
    return light
