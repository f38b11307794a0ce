"""The files others rely on: camera.json, calibration.json, rig.json, points.csv, results.json."""

from station.documents.axle import (
    AxleDocument,
    BackDocument,
    BackToBackDocument,
    StandingDocument,
)
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
    HeaderDocument,
    MeasurementDocument,
    ProfileDocument,
    ReadingDocument,
    WheelDocument,
    wheel_document,
)
from station.documents.piece import (
    PieceCheck,
    PieceDocument,
    PiecePictureDocument,
    piece_check,
)
from station.documents.points import (
    POINT_COLUMNS,
    points_csv,
    rig_points_csv,
    views_from_points,
)
from station.documents.reference import (
    REFERENCE_NAME,
    MeasuredWheel,
    NominalDocument,
    ReferenceDocument,
    ReferencePoints,
    reference_nominal,
    reference_points,
)
from station.documents.rig import (
    BOARD_SIGMA_MM,
    RigDocument,
    RigSensorDocument,
    SurveyDocument,
    sensors_of,
)

__all__ = [
    "BOARD_SIGMA_MM",
    "POINT_COLUMNS",
    "REFERENCE_NAME",
    "AxleDocument",
    "BackDocument",
    "BackToBackDocument",
    "CalibrationDocument",
    "CameraDocument",
    "Gate",
    "HeaderDocument",
    "InputFile",
    "MeasuredWheel",
    "MeasurementDocument",
    "MountingDocument",
    "PieceCheck",
    "PieceDocument",
    "PiecePictureDocument",
    "NominalDocument",
    "PlaneDocument",
    "PoseDocument",
    "ProfileDocument",
    "ReadingDocument",
    "ReferenceDocument",
    "ReferencePoints",
    "RigDocument",
    "RigSensorDocument",
    "RmsDocument",
    "StandingDocument",
    "SurveyDocument",
    "WheelDocument",
    "piece_check",
    "points_csv",
    "reference_nominal",
    "reference_points",
    "rig_points_csv",
    "sensors_of",
    "views_from_points",
    "wheel_document",
    "write_whole",
    "written_whole",
]
