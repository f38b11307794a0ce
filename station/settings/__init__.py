"""The station's settings: one typed tree, read once at start from TOML and the environment."""

from station.settings.controller import ControllerSettings
from station.settings.credentials import CREDENTIALS, credential
from station.settings.fleet import FleetSettings
from station.settings.limits import LimitSettings, LimitsSettings, RangeSettings
from station.settings.load import load_settings
from station.settings.measuring import MeasuringSettings
from station.settings.recalibration import (
    DAYS,
    CaptureSettings,
    GateSettings,
    PieceSettings,
    PolicySettings,
    RecalibrationSettings,
    SensorRecalibrationSettings,
)
from station.settings.replay import ReplaySettings
from station.settings.rig import MAX_SKEW_US, RigSettings
from station.settings.sensor import (
    ExposureSettings,
    MountingSettings,
    RegionSettings,
    SensorId,
    SensorSettings,
)
from station.settings.station import LogLevel, StationSettings
from station.settings.storage import StorageSettings
from station.settings.track import TrackSettings
from station.settings.web import TlsSettings, WebSettings

__all__ = [
    "CREDENTIALS",
    "DAYS",
    "MAX_SKEW_US",
    "CaptureSettings",
    "ControllerSettings",
    "ExposureSettings",
    "FleetSettings",
    "GateSettings",
    "LimitSettings",
    "LimitsSettings",
    "LogLevel",
    "MeasuringSettings",
    "MountingSettings",
    "PieceSettings",
    "PolicySettings",
    "RangeSettings",
    "RecalibrationSettings",
    "RegionSettings",
    "ReplaySettings",
    "RigSettings",
    "SensorId",
    "SensorRecalibrationSettings",
    "SensorSettings",
    "StationSettings",
    "StorageSettings",
    "TlsSettings",
    "TrackSettings",
    "WebSettings",
    "credential",
    "load_settings",
]
