"""The tables of the store.  Whoever changes one writes the migration beside them."""

from station.store.tables.base import JsonObject, Table, UtcDateTime
from station.store.tables.calibrations import (
    Activation,
    Calibration,
    CalibrationPoints,
    RigActivation,
    RigCalibration,
    RigCalibrationPoints,
)
from station.store.tables.callers import AuditEntry, KeptAnswer, Key, Login
from station.store.tables.changes import Change, Push, StoreEpoch
from station.store.tables.followings import EarlyReading, Following
from station.store.tables.jobs import Job
from station.store.tables.measured import AxleWheel, Measurement, MeasurementProfile
from station.store.tables.recalibrations import KeptPieceCheck, Recalibration
from station.store.tables.recorded import CalibrationSession, Pass, Recording
from station.store.tables.replays import Replay, ReplayMeasurement

__all__ = [
    "Activation",
    "AuditEntry",
    "AxleWheel",
    "Calibration",
    "CalibrationPoints",
    "CalibrationSession",
    "Change",
    "EarlyReading",
    "Following",
    "Job",
    "JsonObject",
    "KeptAnswer",
    "KeptPieceCheck",
    "Key",
    "Login",
    "Measurement",
    "MeasurementProfile",
    "Pass",
    "Push",
    "Recalibration",
    "Recording",
    "Replay",
    "ReplayMeasurement",
    "RigActivation",
    "RigCalibration",
    "RigCalibrationPoints",
    "StoreEpoch",
    "Table",
    "UtcDateTime",
]
