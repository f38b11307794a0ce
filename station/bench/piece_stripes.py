"""Stripes on a reference piece: by rendered pictures, and by points with noise of known law."""

from dataclasses import dataclass

import numpy as np

from calib import (
    Cause,
    FloatArray,
    LaserSensor,
    StripePoints,
    calibrate,
    kernel_of,
    locate_stripe,
)
from measure import Piece
from station.bench.paper_pictures import TARGET, see_targets
from station.scenes import Light, PieceScene, paper_sensor, piece_pose

_WIDTH_PX = 1.25
_PEAK = 180.0
_COUNTED_PX = 0.002
_STEP_MM = 0.01
_FACING = 0.2


@dataclass(frozen=True, slots=True)
class Held:
    """Where a piece is held: where its middle is seen, and how it is turned in the sheet."""

    middle_px: tuple[float, float]
    turn_rad: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Held":
        """Hold it about the middle of the field."""
        u, v = rng.uniform([750.0, 450.0], [1250.0, 700.0])
        return cls((float(u), float(v)), float(rng.uniform(-0.25, 0.25)))


def calibrated_sensor(pictures: int, seed: int) -> LaserSensor:
    """Return the true sensor with the covariance that a calibration tells."""
    truth = paper_sensor()
    views = [seen.view for seen in see_targets(truth, (Light.GOOD,), pictures, [seed, 7])]
    camera = truth.camera
    found = calibrate(views, TARGET, width=camera.width, height=camera.height)
    return LaserSensor(camera, truth.plane, found.sensor.covariance)


def rendered_stripe(
    piece: Piece,
    truth: LaserSensor,
    held: Held,
    seed: int,
    *,
    believed: LaserSensor | None = None,
    shot: int = 0,
) -> StripePoints:
    """Return the stripe in a rendered picture.

    Parameters
    ----------
    piece, truth, held
        What is seen, by which sensor, and where.
    seed
        Of speckle and surroundings.
    believed
        The piece is held in the sheet of this sensor, and stays there; that of `truth` without.
    shot
        Of the noise of the camera.
    """
    pose = piece_pose(believed or truth, piece, middle_px=held.middle_px, turn_rad=held.turn_rad)
    scene = PieceScene(truth, pose, piece, seed=seed)
    return locate_stripe(scene.render(np.random.default_rng([seed, shot])))


def simulated_stripe(
    piece: Piece, truth: LaserSensor, held: Held, rng: np.random.Generator, noise_px: float
) -> StripePoints:
    """Return a stripe whose centres scatter normally, neighbours as one kernel makes them.

    The edges do not bleed; all else that the picture does is left out too.
    """
    profile, outward = piece.samples(_STEP_MM)
    pose = piece_pose(truth, piece, middle_px=held.middle_px, turn_rad=held.turn_rad)

    def seen(points_mm: FloatArray) -> FloatArray:
        level = np.zeros(len(points_mm))
        in_cam = pose.apply(np.column_stack([points_mm[:, 0], level, points_mm[:, 1]]))
        return truth.camera.project(in_cam)

    eye = pose.inverse().translation_mm[[0, 2]]
    sight = eye - profile
    sight /= np.linalg.norm(sight, axis=1)[:, None]
    facing = np.flatnonzero((sight * outward).sum(axis=1) > _FACING)
    along = np.column_stack([outward[:, 1], -outward[:, 0]])[facing]
    centre = seen(profile[facing])
    step = seen(profile[facing] + 1e-3 * along) - centre
    normal = np.column_stack([-step[:, 1], step[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # One point a pixel of length.
    length = np.concatenate([[0.0], np.linalg.norm(np.diff(centre, axis=0), axis=1).cumsum()])
    index = np.unique(np.floor(length).astype(np.int64), return_index=True)[1]
    off = noise_px * _kernelled(rng, len(index))
    count = len(index)
    return StripePoints(
        centre_px=centre[index] + off[:, None] * normal[index],
        normal=normal[index],
        sigma_px=np.full(count, _COUNTED_PX),
        width_px=np.full(count, _WIDTH_PX),
        peak=np.full(count, _PEAK),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def _kernelled(rng: np.random.Generator, count: int) -> FloatArray:
    """Return noise of unit variance whose neighbours share a kernel, shape (N,)."""
    kernel = float(kernel_of(np.array([_WIDTH_PX]), np.array([_PEAK]))[0])
    reach = int(np.ceil(4.0 * kernel))
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / kernel) ** 2)
    white = rng.normal(size=count + 2 * reach)
    return np.asarray(np.convolve(white, weight / np.linalg.norm(weight), mode="valid"))
