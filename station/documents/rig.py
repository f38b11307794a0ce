"""rig.json: where the sensors of one wheel stand to each other, and what that rests on."""

import hashlib
from collections.abc import Mapping
from typing import Any, Literal, Self

import numpy as np
from pydantic import AwareDatetime, Field, model_validator

from calib import (
    RIG_PARAMETERS,
    SENSOR_PARAMETERS,
    FloatArray,
    LaserSensor,
    Rig,
    RigidTransform,
    RigSensor,
)
from measure import Side, Survey
from station.documents.base import Document
from station.documents.calibration import (
    Gate,
    InputFile,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.documents.camera import CameraDocument
from station.errors import InputUnusable

BOARD_SIGMA_MM = 0.02
"""How far dots of a board are from their places, one sigma, where nobody says: a good print."""
_SYMMETRIC = 1e-6
"""By which part of the sigmas' product two entries that should be equal may differ."""


class SurveyDocument(Document):
    """What is known of the wheels that pass a rig; what is null is as usual."""

    wheel_radius_mm: float = Field(default=420.0, gt=100.0, lt=1000.0)
    sigma_radius_mm: float | None = Field(default=None, gt=0.0)
    sigma_axle_x_mm: float | None = Field(default=None, gt=0.0)
    sigma_height_mm: float | None = Field(default=None, gt=0.0)
    sigma_axle_direction_rad: float | None = Field(default=None, gt=0.0)
    sigma_vibration_mm: float | None = Field(default=None, gt=0.0)
    """How far the sensors move against each other between their exposures."""
    sigma_vibration_rad: float | None = Field(default=None, gt=0.0)

    @classmethod
    def of_mounting(
        cls,
        mounting: MountingDocument,
        *,
        sigma_vibration_mm: float | None = None,
        sigma_vibration_rad: float | None = None,
    ) -> Self:
        """Take over what the survey of the anchor says of wheels, and add the rig's vibration."""
        return cls(
            **mounting.model_dump(exclude={"rotation_vector", "translation_mm"}),
            sigma_vibration_mm=sigma_vibration_mm,
            sigma_vibration_rad=sigma_vibration_rad,
        )

    def survey(self) -> Survey:
        """Return it as what measures wheels takes it."""
        return Survey(**self.model_dump(exclude_none=True))


class RigSensorDocument(Document):
    """One sensor of a rig: what it is, and rig_from_camera."""

    sensor: str
    calibration: str
    """Fingerprint of the calibration that it rests on."""
    camera: CameraDocument
    plane: PlaneDocument
    rotation_vector: tuple[float, float, float]
    translation_mm: tuple[float, float, float]
    depths_mm: tuple[float, float] | None = None
    """Nearest and farthest point of the stripes it was calibrated with, before its camera."""

    @classmethod
    def of(
        cls, placed: RigSensor, calibration: str, depths_mm: tuple[float, float] | None = None
    ) -> Self:
        """Describe a sensor of a rig."""
        a, b, c, d = placed.sensor.plane.coefficients.tolist()
        pose = placed.rig_from_camera
        return cls(
            sensor=placed.name,
            calibration=calibration,
            camera=CameraDocument.from_model(placed.sensor.camera),
            plane=PlaneDocument(a=a, b=b, c=c, d=d),
            rotation_vector=tuple(pose.rotation_vector.tolist()),
            translation_mm=tuple(pose.translation_mm.tolist()),
            depths_mm=depths_mm,
        )

    def placed(self, covariance: FloatArray) -> RigSensor:
        """Return the sensor with its own covariance, shape (13, 13)."""
        return RigSensor(
            self.sensor,
            LaserSensor(self.camera.model(), self.plane.plane(), covariance),
            RigidTransform.from_rotation_vector(self.rotation_vector, self.translation_mm),
        )


class RigDocument(Document):
    """One calibration of one rig."""

    format: Literal["treadline-rig"] = "treadline-rig"
    version: Literal[1] = 1
    rig: str = Field(min_length=1)
    side: Side
    created: AwareDatetime
    software: str
    method: Literal["boards", "board", "piece", "survey"]
    """From two rigid boards, one board that all saw, a reference piece, or the survey alone."""
    anchor: str
    """The sensor that carries the frame."""
    sensors: tuple[RigSensorDocument, ...] = Field(min_length=1)
    covariance: tuple[tuple[float, ...], ...]
    """Joint, for each sensor: fx fy cx cy k1 k2 p1 p2 k3 a b c d, then turn and shift x y z."""
    survey: SurveyDocument | None = None
    """What is known of passing wheels; null where the frame is that of the anchor's camera."""
    rms: RmsDocument | None
    """Null of a rig from a piece, whose points lie off it by `quality.piece_rms_mm`."""
    quality: dict[str, Gate]
    """The gates and their figures."""
    options: dict[str, Any]
    inputs: tuple[InputFile, ...]
    warnings: tuple[str, ...] = ()
    left_out: dict[str, str] = Field(default_factory=dict)
    """Showings, or pictures, that were not used, and why."""

    @model_validator(mode="after")
    def _sensors_make_a_rig(self) -> Self:
        names = self.names
        if len(set(names)) < len(names):
            raise ValueError(f"sensors are named {', '.join(names)}; give each a name of its own")
        if self.anchor not in names:
            raise ValueError(
                f"the anchor is {self.anchor}; allowed: one of the sensors, {', '.join(names)}"
            )
        _ensure_covariance(self.covariance, len(RIG_PARAMETERS) * len(names))
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The sensors' names, in order."""
        return tuple(each.sensor for each in self.sensors)

    @property
    def passed(self) -> bool:
        """Whether every gate was passed."""
        return all(gate.passed for gate in self.quality.values())

    @property
    def fingerprint(self) -> str:
        """SHA-256 over the content, by which results name the rig they rest on."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()

    @property
    def calibrations(self) -> dict[str, str]:
        """Fingerprints of the calibrations it rests on, by sensor."""
        return {each.sensor: each.calibration for each in self.sensors}

    def to_rig(self) -> Rig:
        """Return the rig itself."""
        covariance = np.array(self.covariance)
        size, own = len(RIG_PARAMETERS), len(SENSOR_PARAMETERS)
        blocks = [slice(at, at + own) for at in range(0, len(covariance), size)]
        placed = [
            each.placed(covariance[block, block])
            for each, block in zip(self.sensors, blocks, strict=True)
        ]
        return Rig(tuple(placed), covariance)

    def survey_of_wheels(self) -> Survey:
        """Return what is known of passing wheels.

        Raises
        ------
        InputUnusable
            If the rig does not say where it stands beside the track.
        """
        if self.survey is None:
            raise InputUnusable(
                f"rig {self.rig} does not say where it stands beside the track, so it cannot "
                f"measure wheels; calibrate it with a calibration of {self.anchor} that has a "
                "mounting"
            )
        return self.survey.survey()


def sensors_of(
    rig: Rig,
    calibrations: Mapping[str, str],
    depths_mm: Mapping[str, tuple[float, float]] | None = None,
) -> tuple[RigSensorDocument, ...]:
    """Describe the sensors of a rig, with the fingerprint of each one's calibration."""
    depths = depths_mm or {}
    return tuple(
        RigSensorDocument.of(each, calibrations[each.name], depths.get(each.name))
        for each in rig.sensors
    )


def _ensure_covariance(rows: tuple[tuple[float, ...], ...], size: int) -> None:
    if not (len(rows) == size and all(len(row) == size for row in rows)):
        raise ValueError(
            f"covariance has {len(rows)} rows; allowed: {size} x {size}, "
            f"{len(RIG_PARAMETERS)} a sensor"
        )
    covariance = np.array(rows)
    variance = np.diag(covariance)
    if not (np.isfinite(covariance).all() and (variance >= 0.0).all()):
        raise ValueError("covariance holds a negative variance or what is no number")
    slack = _SYMMETRIC * np.sqrt(np.outer(variance, variance))
    if not (np.abs(covariance - covariance.T) <= slack).all():
        raise ValueError("covariance is not symmetric; give the file as `station` wrote it")
