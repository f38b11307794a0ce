"""The station's settings: one typed tree, read once at start from TOML and the environment."""

from station.settings.limits import LimitSettings, LimitsSettings
from station.settings.load import load_settings
from station.settings.sensor import (
    ExposureSettings,
    MountingSettings,
    RegionSettings,
    SensorId,
    SensorSettings,
)
from station.settings.station import StationSettings
from station.settings.storage import StorageSettings

__all__ = [
    "ExposureSettings",
    "LimitSettings",
    "LimitsSettings",
    "MountingSettings",
    "RegionSettings",
    "SensorId",
    "SensorSettings",
    "StationSettings",
    "StorageSettings",
    "load_settings",
]
