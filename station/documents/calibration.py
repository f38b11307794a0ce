"""calibration.json: the answer, and what went in, so that it can be questioned later."""

import hashlib
import math
from typing import Any, Literal, Self

import numpy as np
from pydantic import AwareDatetime, Field, model_validator

from calib import SENSOR_PARAMETERS, LaserSensor, LightPlane, RigidTransform
from measure import Mounting
from station.documents.base import Document
from station.documents.camera import CameraDocument
from station.settings import MountingSettings

_Row4 = tuple[float, float, float, float]


class PlaneDocument(Document):
    """a x + b y + c z + d = 0, camera frame, mm, unit normal, d not negative."""

    a: float
    b: float
    c: float
    d: float = Field(ge=0.0)

    @model_validator(mode="after")
    def _check_unit_normal(self) -> Self:
        length = math.hypot(self.a, self.b, self.c)
        if not abs(length - 1.0) <= 1e-6:
            raise ValueError(f"the normal (a, b, c) has length {length:.6g}; allowed: 1")
        return self

    def plane(self) -> LightPlane:
        """Return the plane itself."""
        return LightPlane.from_coefficients([self.a, self.b, self.c, self.d])


class RmsDocument(Document):
    """Root mean square of the residuals of the points used."""

    dots_px: float
    stripe_px: float


class PoseDocument(Document):
    """cam_from_board of one picture."""

    image: str
    rotation_vector: tuple[float, float, float]
    translation_mm: tuple[float, float, float]


class InputFile(Document):
    """A file that went in."""

    name: str
    sha256: str


class Gate(Document):
    """One demand on the calibration, and its figure."""

    value: float
    limit: float
    passed: bool


class MountingDocument(Document):
    """How the sensor stood beside the track when it was calibrated."""

    rotation_vector: tuple[float, float, float]
    """Of rig_from_camera, rad."""
    translation_mm: tuple[float, float, float]
    """Of rig_from_camera."""
    wheel_radius_mm: float = Field(default=420.0, gt=100.0, lt=1000.0)
    sigma_radius_mm: float | None = Field(default=None, gt=0.0)
    sigma_axle_x_mm: float | None = Field(default=None, gt=0.0)
    sigma_height_mm: float | None = Field(default=None, gt=0.0)
    sigma_axle_direction_rad: float | None = Field(default=None, gt=0.0)

    @classmethod
    def from_settings(cls, mounting: MountingSettings) -> Self:
        """Take over the survey in the settings of a sensor."""
        return cls(**mounting.model_dump())

    def settings(self) -> MountingSettings:
        """Return the survey as the settings of a sensor have it."""
        return MountingSettings(**self.model_dump())

    def rig_from_camera(self) -> RigidTransform:
        """Return the survey as a motion."""
        return RigidTransform.from_rotation_vector(self.rotation_vector, self.translation_mm)

    def mounting(self) -> Mounting:
        """Return the survey as what measures wheels takes it."""
        said = self.model_dump(exclude_none=True, exclude={"rotation_vector", "translation_mm"})
        return Mounting(rig_from_camera=self.rig_from_camera(), **said)


class CalibrationDocument(Document):
    """One calibration of one sensor."""

    format: Literal["treadline-calibration"] = "treadline-calibration"
    version: Literal[1] = 1
    sensor: str
    created: AwareDatetime
    software: str
    method: str
    camera: CameraDocument
    plane: PlaneDocument
    plane_covariance: tuple[_Row4, _Row4, _Row4, _Row4]
    """Of (a, b, c, d)."""
    sensor_covariance: tuple[tuple[float, ...], ...] | None = None
    """Joint, of (fx fy cx cy k1 k2 p1 p2 k3 a b c d)."""
    rms: RmsDocument
    poses: tuple[PoseDocument, ...]
    quality: dict[str, Gate]
    """The gates and their figures."""
    options: dict[str, Any]
    inputs: tuple[InputFile, ...]
    warnings: tuple[str, ...] = ()
    left_out: dict[str, str] = Field(default_factory=dict)
    """Pictures that were not used, and why."""
    mounting: MountingDocument | None = None

    @model_validator(mode="after")
    def _check_joint_covariance(self) -> Self:
        size = len(SENSOR_PARAMETERS)
        joint = self.sensor_covariance
        if joint is not None and not (len(joint) == size and all(len(r) == size for r in joint)):
            raise ValueError(f"sensor_covariance must be {size} x {size}")
        return self

    @property
    def passed(self) -> bool:
        """Whether every gate was passed."""
        return all(gate.passed for gate in self.quality.values())

    @property
    def fingerprint(self) -> str:
        """SHA-256 over the content, by which results name the calibration they rest on."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()

    def laser_sensor(self) -> LaserSensor:
        """Return the sensor; without a joint covariance, camera and plane count as independent."""
        camera = self.camera.model()
        if self.sensor_covariance is not None:
            covariance = np.array(self.sensor_covariance)
        else:
            covariance = np.zeros((len(SENSOR_PARAMETERS), len(SENSOR_PARAMETERS)))
            covariance[:9, :9] = camera.covariance
            covariance[9:, 9:] = self.plane_covariance
        return LaserSensor(camera, self.plane.plane(), covariance)
