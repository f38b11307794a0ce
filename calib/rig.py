"""Sensors that look at one thing from several sides, in one frame; a single one is the simplest."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from calib.arrays import FloatArray, IntArray, frozen
from calib.rigid import RigidTransform
from calib.sensor import SENSOR_PARAMETERS, LaserSensor

POSE_PARAMETERS = ("turn_x", "turn_y", "turn_z", "shift_x", "shift_y", "shift_z")
RIG_PARAMETERS = (*SENSOR_PARAMETERS, *POSE_PARAMETERS)
"""Of each sensor of a rig: its own, then a small rotation (rad), applied to rig_from_camera from
the left about the camera's centre, and a shift (mm), both along the axes of the rig."""
_OWN = slice(0, len(SENSOR_PARAMETERS))
_POSE = slice(len(SENSOR_PARAMETERS), None)
_TURN, _SHIFT = slice(-6, -3), slice(-3, None)
"""Parts of the parameters of one sensor."""
_LEAST_EIGENVALUE = 1e-10
"""Of a correlation matrix, by its greatest. In calibrations of 12 and 20 views what is held and a
plane's length stand at 3e-17, the least of what the views tell at 4e-5."""


@dataclass(frozen=True, slots=True, eq=False)
class RigSensor:
    """One sensor of a rig: its name, what it is, and where it stands."""

    name: str
    sensor: LaserSensor
    rig_from_camera: RigidTransform

    def locate(self, pixels_px: FloatArray) -> FloatArray:
        """Return the points on its sheet that pixels, shape (N, 2), show, in the rig frame and mm.

        Shape (N, 3); NaN where a ray does not meet the sheet in front of the camera.
        """
        return self.rig_from_camera.apply(self.sensor.locate(pixels_px))


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """The sensors of one wheel, or of several, in one frame.

    Attributes
    ----------
    sensors
        In a fixed order, each with a name of its own.
    covariance
        Shape (19 K, 19 K), joint, for each sensor in the order of `RIG_PARAMETERS`. The frame is
        without doubt by itself: where a sensor carries it, that one's pose has no variance.

    Raises
    ------
    ValueError
        If there is no sensor, two share a name, or the covariance is not of this size.
    """

    sensors: tuple[RigSensor, ...]
    covariance: FloatArray

    def __post_init__(self) -> None:
        if not self.sensors or len(set(self.names)) < len(self.names):
            raise ValueError(f"sensors must have a name each, and be one or more; got {self.names}")
        size = len(self.sensors) * len(RIG_PARAMETERS)
        object.__setattr__(self, "covariance", frozen(self.covariance, (size, size), "covariance"))

    @classmethod
    def of_one(cls, sensor: LaserSensor, rig_from_camera: RigidTransform, name: str = "") -> Self:
        """Make the simplest rig: one sensor, whose pose is the frame."""
        size = len(RIG_PARAMETERS)
        covariance = np.zeros((size, size))
        covariance[: len(SENSOR_PARAMETERS), : len(SENSOR_PARAMETERS)] = sensor.covariance
        return cls((RigSensor(name, sensor, rig_from_camera),), covariance)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the sensors, in order."""
        return tuple(each.name for each in self.sensors)

    def __getitem__(self, name: str) -> RigSensor:
        return self.sensors[self.names.index(name)]

    def columns(self, name: str) -> IntArray:
        """Return which parameters of the covariance are those of a sensor, shape (19,)."""
        size = len(RIG_PARAMETERS)
        return np.arange(size, dtype=np.int64) + self.names.index(name) * size

    def moved(self, other_from_rig: RigidTransform) -> "Rig":
        """Return the same rig in another frame, as exactly known beside it as it was."""
        turn = other_from_rig.rotation
        block = np.eye(len(RIG_PARAMETERS))
        block[_TURN, _TURN] = block[_SHIFT, _SHIFT] = turn
        change = np.kron(np.eye(len(self.sensors)), block)
        sensors = tuple(
            replace(each, rig_from_camera=other_from_rig @ each.rig_from_camera)
            for each in self.sensors
        )
        return Rig(sensors, change @ self.covariance @ change.T)

    def with_sensor(self, name: str, sensor: LaserSensor) -> "Rig":
        r"""Return the rig with a sensor as a later calibration found it.

        Notes
        -----
        What the rig's own calibration tells of the poses rests on the sensor as it was taken then:
        with the regression :math:`G = C_{ps} C_{ss}^{-1}` of all else on this sensor's parameters,
        all else moves by :math:`G (s' - s)` and its covariance becomes
        :math:`C_{pp} - G C_{sp} + G C' G^T`. Other sensors' own parameters are held: they have
        calibrations of their own.
        """
        own = self.columns(name)[_OWN]
        rest = np.setdiff1d(np.arange(len(self.covariance)), own)
        gain = _gain_of_poses(self.covariance, own, rest)
        moves = np.zeros(len(self.covariance))
        moves[rest] = gain @ (_parameters(sensor) - _parameters(self[name].sensor))
        sensors = tuple(
            RigSensor(
                each.name,
                sensor if each.name == name else each.sensor,
                moved_by(each.rig_from_camera, moves[self.columns(each.name)[_POSE]]),
            )
            for each in self.sensors
        )
        return Rig(sensors, _with_own(self.covariance, own, rest, gain, sensor.covariance))


def _gain_of_poses(covariance: FloatArray, own: IntArray, rest: IntArray) -> FloatArray:
    """Return the regression of the rest on a sensor's own parameters; zero where it is no pose."""
    poses = np.isin(rest % len(RIG_PARAMETERS), np.arange(len(RIG_PARAMETERS))[_POSE])
    gain = np.zeros((len(rest), len(own)))
    gain[poses] = covariance[np.ix_(rest[poses], own)] @ _inverse(covariance[np.ix_(own, own)])
    return gain


def _with_own(
    covariance: FloatArray, own: IntArray, rest: IntArray, gain: FloatArray, later: FloatArray
) -> FloatArray:
    """Return the covariance with another one of a sensor's own parameters, shape (13, 13)."""
    changed = np.zeros_like(covariance)
    changed[np.ix_(own, own)] = later
    changed[np.ix_(rest, own)] = gain @ later
    changed[np.ix_(own, rest)] = changed[np.ix_(rest, own)].T
    shared = gain @ covariance[np.ix_(own, rest)]
    left = covariance[np.ix_(rest, rest)] - shared - shared.T
    left += gain @ (covariance[np.ix_(own, own)] + later) @ gain.T
    changed[np.ix_(rest, rest)] = left
    return 0.5 * (changed + changed.T)


def moved_by(rig_from_camera: RigidTransform, step: FloatArray) -> RigidTransform:
    """Return a pose after a small step, shape (6,), in the order of `POSE_PARAMETERS`."""
    turn = RigidTransform.from_rotation_vector(step[:3], np.zeros(3)).rotation
    return RigidTransform(
        turn @ rig_from_camera.rotation, rig_from_camera.translation_mm + step[3:]
    )


def _parameters(sensor: LaserSensor) -> FloatArray:
    return np.concatenate([sensor.camera.parameters, sensor.plane.coefficients])


def _inverse(covariance: FloatArray) -> FloatArray:
    """Return the pseudo-inverse; parameters differ by ten orders, and some are held."""
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(
        np.linalg.pinv(covariance / np.outer(safe, safe), rcond=_LEAST_EIGENVALUE, hermitian=True)
        / np.outer(safe, safe)
    )
