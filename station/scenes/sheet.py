"""The laser: a fan of light from one point, thin across, and how brightly it lights a surface."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from calib import FloatArray, LaserSensor, LightPlane, RigidTransform, frozen
from station.scenes.installation import projector_in_cam_mm

_REFERENCE_MM = 593.0  # from the laser to the middle of the field: brightness 1 there
_HALF_FAN_RAD = math.radians(27.0)
_WAVES = 6
_ANGLES_RAD = np.linspace(-1.5, 1.5, 861) * _HALF_FAN_RAD


@dataclass(frozen=True, slots=True, eq=False)
class LaserSheet:
    """A fan of laser light, Gaussian across.

    Attributes
    ----------
    plane
        The middle of the sheet, in the camera frame.
    source_in_cam_mm
        Shape (3,): where the fan starts, a point of the plane.
    axis_in_cam
        Shape (3,), unit: the middle direction of the fan.
    sigma_mm
        Standard deviation across: a quarter of the thickness between the 1/e² places.
    power
        Brightness over that of a sheet as built.
    waves
        Shape (K, 3): amplitude, waves per radian and phase of the unevenness along the fan.
    """

    plane: LightPlane
    source_in_cam_mm: FloatArray
    axis_in_cam: FloatArray
    sigma_mm: float
    power: float
    waves: FloatArray

    def __post_init__(self) -> None:
        source = frozen(self.source_in_cam_mm, (3,), "source_in_cam_mm")
        axis = frozen(self.axis_in_cam, (3,), "axis_in_cam")
        if not abs(float(self.plane.distance_mm(source[None])[0])) < 1e-6:
            raise ValueError("source_in_cam_mm must lie in the plane of the sheet")
        if not (abs(np.linalg.norm(axis) - 1.0) < 1e-9 and self.sigma_mm > 0.0):
            raise ValueError("axis_in_cam must be a unit vector and sigma_mm positive")
        object.__setattr__(self, "source_in_cam_mm", source)
        object.__setattr__(self, "axis_in_cam", axis)
        object.__setattr__(self, "waves", frozen(self.waves, (None, 3), "waves"))

    @classmethod
    def of_sensor(cls, sensor: LaserSensor, rng: np.random.Generator, *, unevenness: float) -> Self:
        """Make the sheet of a sensor: 0.9 mm thick, its fan uneven by a standard deviation."""
        source = projector_in_cam_mm(sensor)
        aim = sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))[0]
        return cls(
            plane=sensor.plane,
            source_in_cam_mm=source,
            axis_in_cam=(aim - source) / np.linalg.norm(aim - source),
            sigma_mm=0.225,
            power=1.0,
            waves=_draw_waves(rng, unevenness),
        )

    def seen_from(self, cam_from_own: RigidTransform) -> "LaserSheet":
        """Return the same sheet in the frame of another camera."""
        normal = cam_from_own.rotation @ self.plane.normal_in_cam
        source = cam_from_own.apply(self.source_in_cam_mm[None])[0]
        return replace(
            self,
            plane=LightPlane.from_coefficients([*normal, -float(normal @ source)]),
            source_in_cam_mm=source,
            axis_in_cam=cam_from_own.rotation @ self.axis_in_cam,
        )

    def reflected_through(
        self, ends_in_cam_mm: FloatArray, rng: np.random.Generator, *, power: float
    ) -> "LaserSheet":
        """Return a false sheet, thrown by something shiny, that meets two points, shape (2, 3)."""
        source = self.source_in_cam_mm + rng.normal(scale=25.0, size=3)
        aim = ends_in_cam_mm.mean(axis=0)
        normal = np.cross(ends_in_cam_mm[0] - source, ends_in_cam_mm[1] - source)
        return LaserSheet(
            plane=LightPlane.from_coefficients([*normal, -float(normal @ source)]),
            source_in_cam_mm=source,
            axis_in_cam=(aim - source) / np.linalg.norm(aim - source),
            sigma_mm=self.sigma_mm * rng.uniform(1.0, 1.5),
            power=power,
            waves=_draw_waves(rng, 0.25),
        )

    def irradiance(self, points_in_cam_mm: FloatArray, normals_in_cam: FloatArray) -> FloatArray:
        r"""Return how brightly the sheet lights pieces of surface.

        Parameters
        ----------
        points_in_cam_mm
            Shape (N, 3).
        normals_in_cam
            Shape (N, 3) or (3,), unit, outward.

        Returns
        -------
        irradiance
            Shape (N,): 1 on a surface square to the light, in the middle of the sheet and fan,
            593 mm from the laser. Zero on surfaces that face away.

        Notes
        -----
        At distance r from the laser, q from the middle of the sheet and angle t in the fan,
        :math:`E = F(t) (r_0 / r) \exp(-q^2 / 2 s^2) \cos i`. The fan F is flat with soft ends,
        as a Powell lens makes it. The sheet's thickness swells by a tenth along the fan.
        """
        beams = points_in_cam_mm - self.source_in_cam_mm
        distance = np.sqrt(np.einsum("ij,ij->i", beams, beams))
        across = np.cross(self.plane.normal_in_cam, self.axis_in_cam)
        angle = np.arctan2(beams @ across, beams @ self.axis_in_cam)
        sigma = self.sigma_mm * (1.0 + 0.1 * np.sin(7.0 * angle + self.waves[0, 2]))
        cosine = (
            -np.einsum("ij,ij->i", beams, np.broadcast_to(normals_in_cam, beams.shape)) / distance
        )
        profile = np.exp(-0.5 * (self.plane.distance_mm(points_in_cam_mm) / sigma) ** 2)
        bright = self.power * self._fan(angle) * _REFERENCE_MM / distance
        return np.asarray(bright * profile * np.maximum(cosine, 0.0))

    @property
    def reference_mm(self) -> float:
        """Distance from the source at which `power` is the brightness."""
        return _REFERENCE_MM

    @property
    def reach_mm(self) -> float:
        """Distance from the middle beyond which the sheet gives less than 4e-5 of its light."""
        return 4.5 * 1.1 * self.sigma_mm

    def _fan(self, angle_rad: FloatArray) -> FloatArray:
        # Tabulated: 0.1 degrees is a thirtieth of the shortest wave.
        waves = np.sin(np.multiply.outer(_ANGLES_RAD, self.waves[:, 1]) + self.waves[:, 2])
        uneven = 1.0 + waves @ self.waves[:, 0]
        soft_ends = np.exp(-2.0 * (_ANGLES_RAD / _HALF_FAN_RAD) ** 6)
        table = np.maximum(uneven, 0.05) * soft_ends
        return np.asarray(np.interp(angle_rad, _ANGLES_RAD, table, left=0.0, right=0.0))


def _draw_waves(rng: np.random.Generator, unevenness: float) -> FloatArray:
    # The laser's beam is smooth: its unevenness has 1 to 8 waves over the fan.
    amplitude = rng.rayleigh(size=_WAVES)
    amplitude *= unevenness * math.sqrt(2.0) / np.linalg.norm(amplitude)
    per_radian = 2.0 * math.pi * rng.uniform(1.0, 8.0, _WAVES) / (2.0 * _HALF_FAN_RAD)
    return np.column_stack([amplitude, per_radian, rng.uniform(0.0, 2.0 * math.pi, _WAVES)])
