"""Stripes on worn wheels by plain geometry: what errors do to readings, without a picture."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from calib import BoolArray, Cause, FloatArray, LaserSensor, RigidTransform, StripePoints, kernel_of
from station.scenes import WheelTruth, projector_in_cam_mm
from station.scenes.revolution import Revolution

_SPACING_PX = 1.0
_EVEN_PX = 0.25
_GRAZING = 0.03
"""Cosine at which light or sight is lost on a surface."""


@dataclass(frozen=True, slots=True)
class StripeNoise:
    """How the points of a stripe scatter across it; the defaults are those of rendered wheels.

    Attributes
    ----------
    sigma_px
        Of each point by itself; the stripe tells it.
    speckle_px
        What neighbours share and the stripe does not tell.
    grain_px
        Standard deviation of the window over which they share it.
    """

    sigma_px: float = 0.004
    speckle_px: float = 0.045
    grain_px: float = 1.7


@dataclass(frozen=True, slots=True, eq=False)
class PlacedWheel:
    """A wheel where it truly stands before a sensor.

    Attributes
    ----------
    wheel
        Its shape.
    sensor, rig_from_camera
        The sensor, and where it stands beside the wheel's own rail: y along the axle.
    axle_x_mm, lateral_mm, lifted_mm
        Place of the axle along the rail and across it, and its height over the wheel's radius.
    """

    wheel: WheelTruth
    sensor: LaserSensor
    rig_from_camera: RigidTransform
    axle_x_mm: float = 0.0
    lateral_mm: float = 0.0
    lifted_mm: float = 0.0

    def stripe(
        self,
        rng: np.random.Generator,
        noise: StripeNoise,
        *,
        width_px: float = 1.2,
        pull: float = 1.0,
    ) -> StripePoints:
        """Draw the stripe: about a point a pixel, scattered and drawn to the inside of bends.

        Parameters
        ----------
        rng
            Draws the scatter.
        noise
            How much of it there is.
        width_px
            Standard deviation of the stripe's profile.
        pull
            Factor on what theory says of the pull of a bend.
        """
        points, lit = self._cut_in_cam_mm()
        even, tangent, inwards_px = _even_line(self.sensor.camera.project(points), width_px)
        seen = _seen(even, points, lit, self.sensor)
        normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])[seen]
        count = len(normal)
        grains = gaussian_filter1d(rng.normal(size=count), noise.grain_px / _SPACING_PX)
        grains *= np.sqrt(2.0 * np.sqrt(np.pi) * noise.grain_px / _SPACING_PX)
        moved = noise.sigma_px * rng.normal(size=count) + noise.speckle_px * grains
        moved += pull * inwards_px[seen]
        return StripePoints(
            centre_px=even[seen] + moved[:, None] * normal,
            normal=normal,
            sigma_px=np.full(count, noise.sigma_px),
            width_px=np.full(count, width_px),
            peak=np.full(count, 150.0),
            saturated=np.zeros(count, dtype=bool),
            cause=(Cause.NONE,) * count,
        )

    def _cut_in_cam_mm(self) -> tuple[FloatArray, BoolArray]:
        """Return where the sheet meets the wheel, shape (N, 3), and where light and sight reach."""
        outline = self.wheel.profile
        y, radius = outline.points_mm[:, 0], self.wheel.radius_mm + outline.points_mm[:, 1]
        axle = np.array([self.axle_x_mm, self.lateral_mm, self.wheel.radius_mm + self.lifted_mm])
        normal = self.rig_from_camera.rotation @ self.sensor.plane.normal_in_cam
        camera = self.rig_from_camera.translation_mm
        # In the plane square to the axle at y the sheet is a line, `height` from the axle.
        steep = np.hypot(normal[0], normal[2])
        across = normal[[0, 2]] / steep
        along = np.array([-across[1], across[0]])
        along *= np.sign(along @ (camera - axle)[[0, 2]])
        to_sheet = normal @ (camera - axle) - self.sensor.plane.offset_mm
        height = (to_sheet - normal[1] * y) / steep
        reach = np.sqrt(radius**2 - height**2)
        flat = height[:, None] * across + reach[:, None] * along
        in_rig = axle + np.column_stack([flat[:, 0], y, flat[:, 1]])
        lateral, outward = outline.normals.T
        spread = flat * (outward / radius)[:, None]
        surface = np.column_stack([spread[:, 0], lateral, spread[:, 1]])
        laser = self.rig_from_camera.apply(projector_in_cam_mm(self.sensor)[None])[0]
        lit = _faces(surface, camera - in_rig) & _faces(surface, laser - in_rig)
        body = Revolution(outline, self.wheel.radius_mm, RigidTransform(np.eye(3), axle))
        for eye in (camera, laser):
            lit[lit] = body.sees(in_rig[lit], eye)
        return self.rig_from_camera.inverse().apply(in_rig), lit


def _faces(normal: FloatArray, way: FloatArray) -> BoolArray:
    cosine = np.sum(normal * way, axis=1) / np.linalg.norm(way, axis=1)
    return np.asarray(cosine > _GRAZING)


def _even_line(pixels_px: FloatArray, width_px: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    r"""Return evenly spaced places of a line, its direction, and how far blur draws it across.

    A spread of variance :math:`\tau^2` takes the chord for the arc: curvature times
    :math:`\tau^2 / 2`; the detector's kernel adds its own variance.
    """
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(pixels_px, axis=0), axis=1))])
    fine = np.arange(0.0, length[-1], _EVEN_PX)
    line = np.column_stack([np.interp(fine, length, column) for column in pixels_px.T])
    # The blur itself does not follow a corner of the outline; over a pixel and a half none is left.
    smooth = gaussian_filter1d(line, 1.5 / _EVEN_PX, axis=0, mode="nearest")
    step = np.gradient(smooth, _EVEN_PX, axis=0)
    bend = np.gradient(step, _EVEN_PX, axis=0)
    speed = np.linalg.norm(step, axis=1)
    curvature = (bend[:, 0] * step[:, 1] - bend[:, 1] * step[:, 0]) / speed**3
    variance = width_px**2 + float(kernel_of(np.array([width_px]))[0]) ** 2
    every = slice(None, None, round(_SPACING_PX / _EVEN_PX))
    tangent = (step / speed[:, None])[every]
    return line[every], tangent, (curvature * variance / 2.0)[every]


def _seen(
    places_px: FloatArray, points_in_cam_mm: FloatArray, lit: BoolArray, sensor: LaserSensor
) -> BoolArray:
    """Return which places of the line are lit and inside the picture."""
    camera = sensor.camera
    pixels = camera.project(points_in_cam_mm)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(pixels, axis=0), axis=1))])
    at = np.searchsorted(length, np.arange(len(places_px)) * _SPACING_PX)
    size = np.array([camera.width, camera.height])
    inside = (places_px > 1.0).all(axis=1) & (places_px < size - 2.0).all(axis=1)
    return np.asarray(lit[np.minimum(at, len(lit) - 1)] & inside)
