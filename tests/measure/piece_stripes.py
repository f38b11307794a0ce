"""Stripes on a piece by plain geometry: its profile in the sheet, projected."""

import numpy as np

from calib import CameraModel, Cause, LaserSensor, LightPlane, SheetFrame, StripePoints
from measure import Piece

WIDTH_PX = 1.25
KERNEL_PX = 1.5  # what `kernel_of` takes for that width
_PARAMETERS = (2315.0, 2312.0, 1004.0, 555.0, -0.1267, 0.1204, 0.0, 0.0, 0.0)
SENSOR = LaserSensor.exact(
    CameraModel.from_parameters(np.array(_PARAMETERS), width=2048, height=1088),
    LightPlane.from_coefficients([0.0151, 0.8186, -0.5742, 279.06]),
)
# Of a calibration on twenty pictures, about; correlations left out.
SIGMAS = np.array([0.09, 0.09, 0.05, 0.05, 5e-5, 2e-4, 0, 0, 0, 1e-5, 1e-5, 2e-5, 5e-3])
DOUBTED = LaserSensor(SENSOR.camera, SENSOR.plane, np.diag(SIGMAS**2))


def comb(**about):
    """Flats and flanks of 45 degrees on two levels, 110 mm long."""
    x = [0, 20, 30, 50, 60, 80, 90, 110]
    z = [0, 0, 10, 10, 0, 0, 10, 10]
    return Piece.from_corners("comb", "7", [[(a, b)] for a, b in zip(x, z, strict=True)], **about)


def stripe_on(
    piece,
    rng,
    *,
    sensor=SENSOR,
    noise_px=0.05,
    middle_px=(1000.0, 560.0),
    turn_rad=0.1,
    mirrored=False,
    clutter=0,
    bleed_px=0.0,
):
    """The stripe on a piece held in the sheet, z towards the camera; noise as a kernel has it.

    Within a millimetre of an edge, 5 px of the picture, it is drawn aside by `bleed_px`.
    """
    frame = SheetFrame.of(sensor.plane)
    middle = frame.coordinates(sensor.locate(np.array([middle_px])))[0]
    up = -middle / np.linalg.norm(middle)
    cos, sin = np.cos(turn_rad), np.sin(turn_rad)
    z = np.array([[cos, -sin], [sin, cos]]) @ up
    x = np.array([-z[1], z[0]]) * (-1.0 if mirrored else 1.0)
    turn = np.column_stack([x, z])
    profile, outward = piece.samples(0.01)
    place = (profile - piece.corners_mm.mean(axis=0)) @ turn.T + middle
    sight = -place / np.linalg.norm(place, axis=1)[:, None]
    facing = ((outward @ turn.T) * sight).sum(axis=1) > 0.2
    place, along = place[facing], (outward[:, ::-1] * [1.0, -1.0] @ turn.T)[facing]
    centre = sensor.camera.project(frame.points(place))
    step = sensor.camera.project(frame.points(place + 1e-3 * along)) - centre
    normal = np.column_stack([-step[:, 1], step[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    length = np.concatenate([[0.0], np.linalg.norm(np.diff(centre, axis=0), axis=1).cumsum()])
    index = np.unique(np.floor(length).astype(int), return_index=True)[1]
    off = noise_px * kernelled(rng, len(index))
    from_edges = np.linalg.norm(profile[facing][index][:, None] - piece.corners_mm, axis=2)
    off = off + bleed_px * (from_edges.min(axis=1) < 1.0)
    other_centre, other_normal = _lines(rng, clutter)
    return points_with_noise(
        np.concatenate([centre[index] + off[:, None] * normal[index], other_centre]),
        np.concatenate([normal[index], other_normal]),
    )


def kernelled(rng, count):
    """Noise of unit variance, neighbours correlated by exp(-r^2 / 4 kernel^2)."""
    weight = np.exp(-0.5 * (np.arange(-6, 7) / KERNEL_PX) ** 2)
    return np.convolve(rng.normal(size=count + 12), weight / np.linalg.norm(weight), "valid")


def _lines(rng, count):
    """Edges of other things: straight lines of 300 points across the picture."""
    centres, normals = np.empty((0, 2)), np.empty((0, 2))
    for _ in range(count):
        start, angle = rng.uniform([200, 100], [1500, 900]), rng.uniform(0.0, np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])
        line = start + np.arange(300.0)[:, None] * along
        centres = np.concatenate([centres, line])
        normals = np.concatenate([normals, np.tile([-along[1], along[0]], (300, 1))])
    return centres, normals


def points_with_noise(centre_px, normal):
    """Points of a stripe as located, scattered already."""
    count = len(centre_px)
    return StripePoints(
        centre_px=centre_px,
        normal=normal,
        sigma_px=np.full(count, 0.002),
        width_px=np.full(count, WIDTH_PX),
        peak=np.full(count, 180.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
