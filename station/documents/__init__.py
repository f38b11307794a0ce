"""The files others rely on: camera.json, calibration.json, points.csv, results.json."""

from station.documents.base import write_whole, written_whole
from station.documents.calibration import (
    CalibrationDocument,
    Gate,
    InputFile,
    MountingDocument,
    PlaneDocument,
    PoseDocument,
    RmsDocument,
)
from station.documents.camera import CameraDocument
from station.documents.measurement import (
    MeasurementDocument,
    ProfileDocument,
    ReadingDocument,
    WheelDocument,
    wheel_document,
)
from station.documents.points import POINT_COLUMNS, points_csv, views_from_points

__all__ = [
    "POINT_COLUMNS",
    "CalibrationDocument",
    "CameraDocument",
    "Gate",
    "InputFile",
    "MeasurementDocument",
    "MountingDocument",
    "PlaneDocument",
    "PoseDocument",
    "ProfileDocument",
    "ReadingDocument",
    "RmsDocument",
    "WheelDocument",
    "points_csv",
    "views_from_points",
    "wheel_document",
    "write_whole",
    "written_whole",
]
