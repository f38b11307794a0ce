"""The settings of the whole station."""

from collections import Counter
from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from station.settings.limits import LimitsSettings
from station.settings.section import Section
from station.settings.sensor import SensorSettings
from station.settings.storage import StorageSettings


class StationSettings(Section):
    """The whole station."""

    name: str = "treadline"
    """Name of the station, in every recording and reading."""
    data_dir: Path
    """Folder of recordings, calibrations and the store."""
    host: str = "127.0.0.1"
    """Address the page and API listen on."""
    port: int = Field(default=8080, ge=0, le=65535)
    """Port of the page and API."""
    reference: str = "S1002"
    """Reference profile of the wheels: S1002, LMA or a file."""
    limits: LimitsSettings = Field(default_factory=LimitsSettings)
    """What raises alarms; confirm it by the regulations you are under."""
    storage: StorageSettings = Field(default_factory=StorageSettings)
    """Files and space."""
    sensors: tuple[SensorSettings, ...] = Field(min_length=1)
    """The sensors, one or more."""

    @model_validator(mode="after")
    def _sensors_differ(self) -> Self:
        for what in ("id", "address"):
            counted = Counter(getattr(sensor, what) for sensor in self.sensors)
            twice = [value for value, count in counted.items() if count > 1]
            if twice:
                raise ValueError(f"two sensors with the {what} {twice[0]!r}; give each its own")
        return self

    def sensor(self, sensor_id: str) -> SensorSettings | None:
        """Return the settings of a sensor, or None where the station has no such one."""
        return next((sensor for sensor in self.sensors if sensor.id == sensor_id), None)
