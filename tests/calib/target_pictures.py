"""A small renderer of targets with known truth, for the tests of what is seen in pictures.

It is simple on purpose and shares nothing with what it tests but the camera model: shapes are
drawn at four times the size in coordinates of the board, blurred by a Gaussian lens, averaged to
pixels; noise, saturation and 8 bits come last.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np

from calib import CameraModel, RigidTransform, StripePoints, Target

FINE = 4
CAMERA = CameraModel.from_parameters(
    np.array([2300.0, 2296.0, 398.0, 343.0, -0.13, 0.12, 0.0, 0.0, 0.0]), width=800, height=700
)
DOTS = Target.parse("dots:7x8:12:d=6")
BOARD = Target.parse("chessboard:6x9:9")


def facing(target=DOTS, *, turn=(0.25, -0.3, 0.1), shift_mm=(0.0, 0.0), depth_mm=480.0):
    """Return a pose whose middle point is seen near the middle of the picture."""
    tilt = RigidTransform.from_rotation_vector([turn[0], turn[1], 0.0], np.zeros(3))
    spin = RigidTransform.from_rotation_vector([0.0, 0.0, turn[2]], np.zeros(3))
    rotation = (tilt @ spin).rotation
    middle = 0.5 * (target.points_mm[0] + target.points_mm[-1])
    return RigidTransform(rotation, np.array([*shift_mm, depth_mm]) - rotation @ middle)


@dataclass(frozen=True)
class Line:
    """A stripe along a line of the board: through (x, y) mm, at an angle to its rows."""

    through_mm: tuple[float, float] = (40.0, 27.0)
    angle: float = 0.12
    height: float = 160.0
    width_mm: float = 0.45

    def across_mm(self, x, y):
        # Of Python's numbers: with NumPy's, single precision would become double.
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        return (y - self.through_mm[1]) * cosine - (x - self.through_mm[0]) * sine


@dataclass(frozen=True, eq=False)
class Scene:
    target: Target = DOTS
    pose: RigidTransform = field(default_factory=facing)
    dots: float = 150.0
    ground: float = 14.0
    behind: float = 6.0
    blur_px: float = 0.9
    lines: tuple[Line, ...] = (Line(),)
    glare: tuple[tuple[float, float, float, float], ...] = ()  # u, v, radius px, counts
    texture: float = 0.0
    fall: float = 0.0  # of the brightness, from left to right
    exposure: float = 1.0
    bloom: float = 0.0
    read: float = 1.5
    gain: float = 0.04
    hidden: tuple[tuple[int, int], ...] = ()

    def light(self, seed=0):
        """Return the brightness before noise, shape (H, W)."""
        x, y = _board_coordinates(self.pose.rotation.tobytes(), self.pose.translation_mm.tobytes())
        t, pitch = self.target, self.target.pitch_mm
        on_board = (x > -1.3 * pitch) & (x < (t.cols + 0.3) * pitch)
        on_board &= (y > -1.3 * pitch) & (y < (t.rows + 0.3) * pitch)
        fine = np.where(on_board, self.ground, self.behind).astype(np.float32)
        rng = np.random.default_rng(seed)
        if self.texture:
            grain = cv2.GaussianBlur(rng.normal(size=fine.shape).astype(np.float32), (0, 0), 14.0)
            fine *= 1.0 + self.texture * grain / grain.std()
        if t.kind == "dots":
            fine += _discs(self, x, y, fine)
        else:
            fine = np.where(_white(t, x, y), self.dots, fine).astype(np.float32)
        for line in self.lines:
            d = line.across_mm(x, y) / line.width_mm
            fine += line.height * np.exp(-0.5 * d * d) * on_board
        picture = cv2.GaussianBlur(fine, (0, 0), FINE * self.blur_px)
        picture = cv2.resize(picture, (CAMERA.width, CAMERA.height), interpolation=cv2.INTER_AREA)
        u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
        for gu, gv, radius, counts in self.glare:
            picture = picture + counts * np.exp(-0.5 * ((u - gu) ** 2 + (v - gv) ** 2) / radius**2)
        picture = picture * (1.0 - self.fall * u / CAMERA.width) * self.exposure
        if self.bloom:
            wide = cv2.GaussianBlur(np.minimum(picture, 2000.0), (0, 0), 9.0)
            picture = (1.0 - self.bloom) * picture + self.bloom * wide
        return picture

    def picture(self, rng, seed=0):
        return exposed(self.light(seed), rng, read=self.read, gain=self.gain)

    def true_centres(self):
        """Return the centroids of the discs' pictures, or the corners, (rows, cols, 2)."""
        points = self.target.points_mm
        if self.target.kind == "chessboard":
            centres = CAMERA.project(self.pose.apply(points))
        else:
            centres = np.array([self._disc_centroid(p) for p in points])
        return centres.reshape(self.target.rows, self.target.cols, 2)

    def _disc_centroid(self, point):
        angle = np.linspace(0.0, 2.0 * np.pi, 120, endpoint=False)
        rim = 0.5 * self.target.diameter_mm * np.column_stack([np.cos(angle), np.sin(angle)])
        u, v = CAMERA.project(self.pose.apply(point + np.pad(rim, ((0, 0), (0, 1))))).T
        u2, v2 = np.roll(u, -1), np.roll(v, -1)
        area = u * v2 - u2 * v
        return np.array([((u + u2) * area).sum(), ((v + v2) * area).sum()]) / (3.0 * area.sum())

    def stripe_error_px(self, stripe: StripePoints, line: Line | None = None):
        """Return how far stripe points are from a line's picture, along their normals."""
        line = line or self.lines[0]

        def across(pixels):
            rays = CAMERA.rays(pixels)
            normal, origin = self.pose.rotation[:, 2], self.pose.translation_mm
            on_board = rays * (normal @ origin / (rays @ normal))[:, None]
            x, y, _ = self.pose.inverse().apply(on_board).T
            return line.across_mm(x, y)

        step = 0.5 * stripe.normal
        slope = across(stripe.centre_px + step) - across(stripe.centre_px - step)
        return across(stripe.centre_px) / slope


def exposed(light, rng, *, read=1.5, gain=0.04):
    """Return what an 8-bit sensor makes of light, shot and read noise added."""
    deviation = np.sqrt(read**2 + gain * np.maximum(light, 0.0))
    noisy = light + deviation * rng.standard_normal(light.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


@lru_cache(maxsize=1)
def _board_coordinates(rotation, translation_mm):
    """Return x and y on the board, mm, of a grid four times as fine as the pixels.

    Most scenes have one pose; its parts come as bytes, for them to be told apart.
    """
    pose = RigidTransform(np.frombuffer(rotation).reshape(3, 3), np.frombuffer(translation_mm))
    u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    rays = CAMERA.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64))
    normal, origin = pose.rotation[:, 2], pose.translation_mm
    points = pose.inverse().apply(rays * (normal @ origin / (rays @ normal))[:, None])
    size = (FINE * CAMERA.width, FINE * CAMERA.height)
    # The map bends so little that between pixels a straight line is exact enough (1e-5 px).
    x, y = (points[:, i].reshape(u.shape).astype(np.float32) for i in (0, 1))
    return tuple(cv2.resize(a, size, interpolation=cv2.INTER_LINEAR) for a in (x, y))


def _discs(scene, x, y, ground):
    t = scene.target
    col, row = np.rint(x / t.pitch_mm), np.rint(y / t.pitch_mm)
    r = np.hypot(x - col * t.pitch_mm, y - row * t.pitch_mm)
    inside = (r < 0.5 * t.diameter_mm) & (col >= 0) & (col < t.cols) & (row >= 0) & (row < t.rows)
    for place in scene.hidden:
        inside &= ~((row == place[0]) & (col == place[1]))
    level = 0.2 * scene.ground if t.dark else scene.dots
    return np.where(inside, level - ground, 0.0).astype(np.float32)


def _white(t, x, y):
    i, j = np.floor(x / t.pitch_mm), np.floor(y / t.pitch_mm)
    pattern = (i >= -1) & (i < t.cols) & (j >= -1) & (j < t.rows)
    return np.where(pattern, (i + j) % 2 == 0, True)
