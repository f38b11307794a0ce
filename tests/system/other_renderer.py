"""Pictures of targets drawn by a second hand, to hold seeing and solving against.

It shares nothing with the station's scenes but OpenCV's meaning of a camera: a flat board, two by
two samples a pixel, a sheet of light with a profile, glare painted over the picture, a sensor.
What no lens does (hard patches, JPEG, gamma) is there on purpose: pictures from elsewhere have it,
as they have paper that is not flat, hands that shake, speckle, and a shadow across the board.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from calib import CameraModel, FloatArray, LaserSensor, LightPlane, Picture, RigidTransform, Target

Image = NDArray[np.float32]

_OVERSAMPLING = 2
_TURN_OF_SHEET_DEG = {"vertical": 0.0, "horizontal": 90.0, "diagonal": 38.0}
_DARK_ALBEDO = 0.1
_WALL_MM = 1600.0


@dataclass(frozen=True, slots=True)
class Look:
    """How one kind of picture looks; brightness in counts at the sensor, before it clips."""

    target: Target = field(default_factory=lambda: Target.parse("dots:7x8:12:d=6"))
    stripe: str = "vertical"
    along_row: bool = False
    dot_counts: float = 160.0
    board_counts: float = 25.0
    laser_counts: float = 150.0
    glow_sigma_mm: float = 0.0  # a bare LED: a bell of light in place of a disc
    bow_mm: float = 0.0  # how far the board's middle stands up
    laser_sigma_mm: float = 0.4
    speckle: float = 0.0  # standard deviation over mean
    false_line: str = ""  # cross, parallel: a reflection's, 1.5 times as bright
    blur_px: float = 0.8
    bloom: float = 0.0
    uneven: float = 0.0  # share of the light lost from one side of the picture to the other
    shadow: float = 0.0  # share of the light lost behind the edge of a shadow
    shake_px: float = 0.0  # length of the path that the camera moves by
    glare_counts: float = 0.0
    wall: str = ""  # gravel, checker, holes
    wall_counts: float = 120.0
    gamma: float = 1.0
    jpeg_quality: int = 0
    colour: bool = False


def paper_camera() -> CameraModel:
    """Return the camera of the paper's simulation."""
    return CameraModel.from_parameters(
        np.array([2181.0, 2181.0, 1024.0, 544.0, -0.45, 0.25, 0.0, 0.0, 0.0]),
        width=2048,
        height=1088,
    )


def sensor_of(look: Look) -> LaserSensor:
    """Return a sensor whose sheet starts 250 mm beside the camera and meets its axis at 550 mm."""
    turn = np.deg2rad(_TURN_OF_SHEET_DEG[look.stripe])
    plane = LightPlane.from_coefficients([np.cos(turn), np.sin(turn), -250.0 / 550.0, 250.0])
    return LaserSensor.exact(paper_camera(), plane)


def random_pose(look: Look, sensor: LaserSensor, rng: np.random.Generator) -> RigidTransform:
    """Return a pose in the frame, 380 to 700 mm away, the sheet across the target's middle."""
    target, size = look.target, np.array([sensor.camera.width, sensor.camera.height])
    middle = 0.5 * target.pitch_mm * np.array([target.cols - 1, target.rows - 1, 0.0])
    while True:
        place = sensor.locate(rng.uniform(0.1, 0.9, (1, 2)) * size)[0]
        turn, axis = np.deg2rad(rng.uniform(-35.0, 35.0)), rng.uniform(0.0, 2.0 * np.pi)
        tilt = np.deg2rad(rng.uniform(6.0, 40.0)) * np.array([np.cos(axis), np.sin(axis), 0.0])
        tilted = RigidTransform.from_rotation_vector(tilt, np.zeros(3))
        off = rng.uniform(-0.3, 0.3, 3) * middle
        if look.along_row:
            across = sensor.plane.normal_in_cam @ tilted.rotation
            turn = np.arctan2(across[1], across[0])
            off = np.rint(middle / target.pitch_mm) * target.pitch_mm - middle
        turned = tilted @ RigidTransform.from_rotation_vector([0.0, 0.0, turn], np.zeros(3))
        pose = RigidTransform(turned.rotation, place - turned.rotation @ (middle + off))
        points = pose.apply(target.points_mm)
        if not (380.0 < place[2] < 700.0 and points[:, 2].min() > 200.0):
            continue
        seen = sensor.camera.project(points)
        if ((seen > 12.0) & (seen < size - 13.0)).all():
            return pose


def draw(
    look: Look, sensor: LaserSensor, cam_from_board: RigidTransform, rng: np.random.Generator
) -> Picture:
    """Draw one picture, grey or BGR."""
    board, laser, cover = _board(look, sensor, cam_from_board, rng)
    wall, wall_laser = _wall(look, sensor, rng)
    still = _blurred(wall * (1.0 - cover) + board, look) * _falloff(look, sensor.camera, rng)
    still += _glare(look, sensor.camera, rng)
    red = _blurred(wall_laser * (1.0 - cover) + laser, look)
    if look.colour:
        # A red laser clips red long before it leaks into green and blue.
        parts = [0.9 * still + 0.12 * red, still + 0.2 * red, 0.8 * still + 2.5 * red]
        picture = np.stack([_sensed(part, look, rng) for part in parts], axis=2)
    else:
        picture = _sensed(still + red, look, rng)
    if look.jpeg_quality:
        coded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, look.jpeg_quality])[1]
        picture = np.asarray(cv2.imdecode(coded, cv2.IMREAD_UNCHANGED), dtype=np.uint8)
    return picture


@lru_cache(maxsize=1)
def _rays() -> Image:
    """Return (x/z, y/z) of every sample of the paper's camera, shape (2 H, 2 W, 2)."""
    camera = paper_camera()
    v, u = np.mgrid[: camera.height, : camera.width]
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(np.float64))[:, :2]
    whole = rays.reshape(camera.height, camera.width, 2).astype(np.float32)
    size = (_OVERSAMPLING * camera.width, _OVERSAMPLING * camera.height)
    return np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)


def _board(
    look: Look, sensor: LaserSensor, pose: RigidTransform, rng: np.random.Generator
) -> tuple[Image, Image, Image]:
    """Return the board's own light, the laser's on it, and its share of each pixel."""
    target, camera = look.target, sensor.camera
    low = np.full(2, -1.3 * target.pitch_mm, dtype=np.float32)
    high = np.array([target.cols - 1, target.rows - 1], np.float32) * target.pitch_mm - low
    corners = np.array([[x, y, 0.0] for x in (low[0], high[0]) for y in (low[1], high[1])])
    seen, limit = camera.project(pose.apply(corners)), [camera.width, camera.height]
    first = np.clip(seen.min(axis=0) - 60.0, 0, np.subtract(limit, 2)).astype(int)
    last = np.clip(seen.max(axis=0) + 60.0, first + 2, limit).astype(int)
    start, stop = _OVERSAMPLING * first, _OVERSAMPLING * last
    rays = _rays()[start[1] : stop[1], start[0] : stop[0]]
    # Single precision, 0.1 um at 600 mm, takes half the time.
    turn, origin = (part.astype(np.float32) for part in (pose.rotation, pose.translation_mm))
    normal, across = turn[:, 2], turn[:, :2]
    depth = (normal @ origin) / (rays @ normal[:2] + normal[2])
    points = np.dstack([rays * depth[..., None], depth])
    place = (points - origin) @ across
    if look.bow_mm:
        middle = 0.5 * (low + high)
        rise = look.bow_mm * (1.0 - (((place - middle) / (high - middle)) ** 2).mean(axis=2))
        points = points * (1.0 + rise / (rays @ normal[:2] + normal[2]) / depth)[..., None]
        place = (points - origin) @ across
    sample_mm = depth / (_OVERSAMPLING * camera.fx)
    beyond = np.maximum.reduce([*np.moveaxis(low - place, 2, 0), *np.moveaxis(place - high, 2, 0)])
    inside = np.clip(0.5 - beyond / sample_mm, 0.0, 1.0)
    light, albedo = _pattern(look, place, sample_mm)
    parts = (light * inside, albedo * _laser(look, sensor, points, rng) * inside, inside)
    whole = np.zeros((3, camera.height, camera.width), dtype=np.float32)
    for part, image in zip(parts, whole, strict=True):
        shrunk = cv2.resize(part, tuple(map(int, last - first)), interpolation=cv2.INTER_AREA)
        image[first[1] : last[1], first[0] : last[0]] = shrunk
    return whole[0], whole[1], whole[2]


def _pattern(look: Look, place: FloatArray, sample_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the light of places on the board, and how much of the laser they throw back."""
    target, pitch = look.target, look.target.pitch_mm
    last = np.array([target.cols - 1, target.rows - 1], dtype=np.float32)
    if target.kind == "chessboard":
        wave = np.sin(np.pi * place / pitch) * pitch / np.pi
        edge = np.clip(2.0 * wave / sample_mm[..., None], -1.0, 1.0)
        squares = (np.maximum(-place, place - last * pitch) < pitch).all(axis=2)
        white = np.where(squares, 0.5 + 0.5 * edge.prod(axis=2), 1.0)
        albedo = _DARK_ALBEDO + (1.0 - _DARK_ALBEDO) * white
        return look.board_counts * albedo, albedo
    if look.glow_sigma_mm:
        return look.board_counts + look.dot_counts * _glow(look, place), np.ones(place.shape[:2])
    centre = pitch * np.clip(np.rint(place / pitch), np.float32(0.0), last)
    radius = 0.5 * (target.diameter_mm or 0.5 * pitch)
    dot = np.clip(0.5 + (radius - np.hypot(*np.moveaxis(place - centre, 2, 0))) / sample_mm, 0, 1)
    if target.dark:
        albedo = 1.0 - (1.0 - _DARK_ALBEDO) * dot
        return look.board_counts * albedo, albedo
    return look.board_counts + (look.dot_counts - look.board_counts) * dot, 1.0 - 0.4 * dot


def _glow(look: Look, place: FloatArray) -> FloatArray:
    """Return the light of bells, one at each point of the target, that reach into each other."""
    target = look.target
    light = np.ones(place.shape[:2], dtype=np.float32)
    for along, count in zip(np.moveaxis(place, 2, 0), (target.cols, target.rows), strict=True):
        bells = np.zeros_like(light)
        for index in range(count):
            off = (along - target.pitch_mm * index) / look.glow_sigma_mm
            bells += np.exp(-0.5 * off * off)
        light *= bells
    return light


def _laser(
    look: Look, sensor: LaserSensor, points: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return the counts on points in space of the laser, and of what may be taken for it."""
    a, d = sensor.plane.normal_in_cam.astype(np.float32), sensor.plane.offset_mm
    light = look.laser_counts * np.exp(-0.5 * ((points @ a + d) / look.laser_sigma_mm) ** 2)
    if look.false_line:
        turn = rng.uniform(0.15, 0.6) if look.false_line == "cross" else 0.0
        away = rng.choice([-1.0, 1.0]) * rng.uniform(8.0, 25.0)
        swing = RigidTransform.from_rotation_vector([0.0, 0.0, turn], np.zeros(3)).rotation
        a = swing.astype(np.float32) @ a
        off = points @ a - np.median(points[::16, ::16] @ a) + away
        light += 1.5 * look.laser_counts * np.exp(-0.5 * (off / look.laser_sigma_mm) ** 2)
    if look.speckle:
        grains = cv2.GaussianBlur(rng.standard_normal(light.shape), (0, 0), 1.5)
        light *= np.maximum(1.0 + look.speckle * grains / grains.std(), 0.0)
    return np.asarray(light)


def _wall(look: Look, sensor: LaserSensor, rng: np.random.Generator) -> tuple[Image, Image]:
    """Return what is behind the board, and the laser on it."""
    height, width = sensor.camera.height, sensor.camera.width
    v, u = np.mgrid[:height, :width].astype(np.float32)
    if look.wall == "gravel":
        stones = rng.standard_normal((height // 7 + 1, width // 7 + 1)).astype(np.float32)
        bright = cv2.resize(stones, (width, height), interpolation=cv2.INTER_CUBIC) > 0.0
    elif look.wall == "checker":
        size = rng.uniform(25.0, 60.0)
        bright = (np.floor(u / size) + np.floor(v / size)) % 2 > 0
    elif look.wall == "holes":
        pitch, size = rng.uniform(35.0, 60.0), rng.uniform(7.0, 13.0)
        bright = np.hypot(u % pitch - 0.5 * pitch, v % pitch - 0.5 * pitch) < size
    else:
        bright = np.zeros((height, width), dtype=bool)
    normal, offset_mm = sensor.plane.normal_in_cam.astype(np.float32), sensor.plane.offset_mm
    rays = _rays()[1::_OVERSAMPLING, 1::_OVERSAMPLING]
    off = _WALL_MM * (rays @ normal[:2] + normal[2]) + offset_mm
    laser = 0.3 * look.laser_counts * np.exp(-0.5 * (off / 2.0) ** 2)
    return (6.0 + look.wall_counts * bright).astype(np.float32), laser.astype(np.float32)


def _falloff(look: Look, camera: CameraModel, rng: np.random.Generator) -> Image:
    """Return the share of the light that reaches each pixel."""
    y, x = np.meshgrid(
        *(np.linspace(-0.5, 0.5, size, dtype=np.float32) for size in (camera.height, camera.width)),
        indexing="ij",
        sparse=True,
    )
    angle = rng.uniform(0.0, 2.0 * np.pi)
    along = np.clip(0.5 + 0.7 * (x * np.cos(angle) + y * np.sin(angle)), 0.0, 1.0)
    share = (1.0 - 0.3 * (x**2 + y**2)) * (1.0 - look.uneven * along)
    if look.shadow:
        turn = rng.uniform(0.0, 2.0 * np.pi)
        behind = x * np.cos(turn) + y * np.sin(turn) - rng.uniform(-0.1, 0.1)
        share *= 1.0 - look.shadow * np.clip(0.5 + behind / 0.02, 0.0, 1.0)
    return np.asarray(share, dtype=np.float32)


def _glare(look: Look, camera: CameraModel, rng: np.random.Generator) -> Image:
    """Return three soft blobs and three hard patches of light."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(np.float32)
    light = np.zeros_like(u)
    for soft in (True, True, True, False, False, False) if look.glare_counts else ():
        x, y = rng.uniform(0.2, 0.8, 2) * [camera.width, camera.height]
        angle, size = rng.uniform(0.0, np.pi), rng.uniform(50.0, 130.0)
        a = ((u - x) * np.cos(angle) + (v - y) * np.sin(angle)) / size
        b = ((v - y) * np.cos(angle) - (u - x) * np.sin(angle)) / (0.6 * size)
        shape = np.exp(-0.5 * (a**2 + b**2)) if soft else np.maximum(abs(a), abs(b)) < 0.6
        light += look.glare_counts * shape
    return light


def _blurred(light: Image, look: Look) -> Image:
    sharp = cv2.GaussianBlur(light, (0, 0), look.blur_px)
    if look.shake_px:
        # Along a diagonal, so that rows and columns are both concerned.
        count = round(look.shake_px / np.sqrt(2.0)) | 1
        sharp = cv2.filter2D(sharp, -1, np.eye(count) / count)
    halo = look.bloom * cv2.GaussianBlur(light, (0, 0), 12.0) if look.bloom else 0.0
    return np.asarray(sharp + halo, dtype=np.float32)


def _sensed(light: Image, look: Look, rng: np.random.Generator) -> Picture:
    """Return what a sensor makes of light: 60 electrons a count, 1.5 counts of read noise."""
    sigma = np.sqrt(np.maximum(light, 0.0) / 60.0 + 1.5**2)
    seen = np.clip(light + sigma * rng.standard_normal(light.shape, dtype=np.float32), 0.0, 255.0)
    return np.asarray(np.rint(255.0 * (seen / 255.0) ** (1.0 / look.gamma)), dtype=np.uint8)
