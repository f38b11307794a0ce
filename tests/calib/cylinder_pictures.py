"""Pictures of a laser stripe on a cylinder, drawn piece by piece: light thrown onto the picture.

It shares nothing with the station's scenes: each small piece of the lit strip drops its light
between the four nearest pixels, the whole is blurred evenly, and noise is added.
"""

from dataclasses import dataclass

import cv2
import numpy as np

PIECES_ALONG, PIECES_ACROSS = 6000, 49


@dataclass(frozen=True)
class Look:
    """How a stripe looks: its sheet's thickness and lens (standard deviations), its fading."""

    sheet_mm: float = 0.2
    lens_px: float = 0.8
    fades: bool = True
    peak: float = 180.0
    speckle: float = 0.06


def cylinder_picture(sensor, axis, middle, radius_mm, look, rng):
    """Draw the stripe on a cylinder through a point of its axis, lit from above the picture."""
    # Angles count from the side away from the camera: what is seen is in one piece.
    one = middle - (middle @ axis) * axis
    one /= np.linalg.norm(one)
    other = np.cross(axis, one)
    normal, d = sensor.plane.normal_in_cam, sensor.plane.offset_mm
    angle = np.linspace(0.0, 2.0 * np.pi, PIECES_ALONG, endpoint=False)
    outward = np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)
    rim = middle + radius_mm * outward
    sight = -rim / np.linalg.norm(rim, axis=1)[:, None]
    source = -d * normal + np.cross(normal, [1.0, 0.0, 0.0]) * 300.0
    beam = source - rim
    incidence = (outward * beam).sum(axis=1) / np.linalg.norm(beam, axis=1)
    seen = ((outward * sight).sum(axis=1) > 0.15) & (incidence > 0.02)
    rim, incidence = rim[seen], incidence[seen]
    brightness = incidence if look.fades else np.ones(len(rim))
    off_mm = np.linspace(-3.5, 3.5, PIECES_ACROSS) * look.sheet_mm
    reach = (off_mm[None, :] - sensor.plane.distance_mm(rim)[:, None]) / (normal @ axis)
    pixels = sensor.camera.project((rim[:, None] + reach[..., None] * axis).reshape(-1, 3))
    pixels = pixels.reshape(*reach.shape, 2)
    # A surface looks as bright from everywhere: a piece's light goes with its size in the picture.
    along = np.gradient(pixels, axis=0)
    across = np.gradient(pixels, axis=1)
    size = np.abs(along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0])
    thick = np.exp(-0.5 * (off_mm / look.sheet_mm) ** 2)
    picture = _dropped(pixels, size * brightness[:, None] * thick, sensor.camera)
    picture = cv2.GaussianBlur(picture, (0, 0), look.lens_px)
    grain = cv2.GaussianBlur(rng.normal(size=picture.shape), (0, 0), 0.8)
    level = np.percentile(picture[picture > 0.1 * picture.max()], 98.0)
    picture *= look.peak / level * (1.0 + look.speckle * grain / grain.std())
    picture += 6.0 + rng.normal(size=picture.shape) * np.sqrt(0.6 + picture / 60.0)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _dropped(pixels, light, camera):
    picture = np.zeros((camera.height, camera.width))
    place = pixels.reshape(-1, 2)
    corner = np.floor(place).astype(int)
    part = place - corner
    for right in (0, 1):
        for down in (0, 1):
            share = np.abs(1 - right - part[:, 0]) * np.abs(1 - down - part[:, 1])
            np.add.at(picture, (corner[:, 1] + down, corner[:, 0] + right), share * light.ravel())
    return picture
