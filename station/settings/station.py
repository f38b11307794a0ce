"""The settings of the whole station."""

from collections import Counter
from pathlib import Path
from typing import Literal, Self
from zoneinfo import ZoneInfo

from pydantic import Field, PrivateAttr, field_validator, model_validator

from station.settings.controller import ControllerSettings
from station.settings.fleet import FleetSettings
from station.settings.limits import LimitsSettings
from station.settings.measuring import MeasuringSettings
from station.settings.recalibration import RecalibrationSettings
from station.settings.replay import ReplaySettings
from station.settings.rig import RigSettings
from station.settings.section import Section
from station.settings.sensor import SensorSettings
from station.settings.storage import StorageSettings
from station.settings.track import TrackSettings
from station.settings.web import TlsSettings, WebSettings

LogLevel = Literal["debug", "info", "warning"]


class StationSettings(Section):
    """The whole station."""

    name: str = "treadline"
    """Name of the station, in every recording and reading."""
    data_dir: Path
    """Folder of recordings, calibrations and the store."""
    store_url: str | None = Field(default=None, repr=False)
    """Database of the store, as postgresql://USER:PASSWORD@HOST/DATABASE; absent: a file (SQLite)
    in `data_dir`.  A password is better given as STATION_STORE_URL in the environment, or as the
    credential `store_url`."""
    host: str = "127.0.0.1"
    """Address the page and API listen on."""
    port: int = Field(default=8080, ge=0, le=65535)
    """Port of the page and API."""
    time_zone: str | None = None
    """Zone of the times on the page, as Europe/Berlin; absent: the host's.  Everything else, and
    every file, says its times in UTC."""
    log_level: LogLevel = "info"
    """What is logged: at `info` all that changes something or fails, at `debug` every call too."""
    reference: str = "S1002"
    """Reference profile of the wheels: S1002, LMA or a file."""
    limits: LimitsSettings = Field(default_factory=LimitsSettings)
    """What raises alarms; confirm it by the regulations you are under."""
    measuring: MeasuringSettings = Field(default_factory=MeasuringSettings)
    """When wheels are measured."""
    storage: StorageSettings = Field(default_factory=StorageSettings)
    """Files and space."""
    web: WebSettings = Field(default_factory=WebSettings)
    """What the page and API take from the network."""
    tls: TlsSettings | None = None
    """The certificate of the page and API; absent: plain HTTP, for this host or a proxy on it."""
    controller: ControllerSettings = Field(default_factory=ControllerSettings)
    """When a pass or session ends by itself, its controller being lost."""
    sensors: tuple[SensorSettings, ...] = Field(min_length=1)
    """The sensors, one or more."""
    recalibration: RecalibrationSettings = Field(default_factory=RecalibrationSettings)
    """Calibrating the sensors anew, nightly and on call."""
    replay: ReplaySettings = Field(default_factory=ReplaySettings)
    """Measuring recordings once more."""
    rigs: tuple[RigSettings, ...] = ()
    """Which of them look at the same wheel; a sensor in none is measured by itself."""
    track: TrackSettings | None = None
    """How left and right stand to each other; absent: no axle has a back-to-back distance."""
    fleet: FleetSettings | None = None
    """The fleet's database, which many stations send what they know to; absent: this one stands
    alone."""
    _file: Path | None = PrivateAttr(default=None)

    @property
    def file(self) -> Path | None:
        """The file they were read from; None where they come from a program."""
        return self._file

    def read_from(self, file: Path) -> Self:
        """Return the same, knowing the file they come from."""
        found = self.model_copy()
        found._file = file  # noqa: SLF001  of its own class
        return found

    @field_validator("time_zone")
    @classmethod
    def _is_a_zone(cls, name: str | None) -> str | None:
        try:
            return name if name is None else ZoneInfo(name).key
        except (KeyError, OSError, ValueError) as error:  # all three, by what is wrong with it
            raise ValueError(
                f"time_zone {name!r}: no zone of this host; give one as Europe/Berlin or UTC"
            ) from error

    @model_validator(mode="after")
    def _sensors_differ(self) -> Self:
        for what in ("id", "address"):
            counted = Counter(getattr(sensor, what) for sensor in self.sensors)
            twice = [value for value, count in counted.items() if count > 1]
            if twice:
                raise ValueError(f"two sensors with the {what} {twice[0]!r}; give each its own")
        return self

    @model_validator(mode="after")
    def _recalibrates_its_own_sensors(self) -> Self:
        strange = [name for name in self.recalibration.sensors if self.sensor(name) is None]
        if strange:
            known = ", ".join(each.id for each in self.sensors)
            raise ValueError(f"recalibration of sensor {strange[0]!r}; the station has {known}")
        return self

    @model_validator(mode="after")
    def _rigs_fit_the_sensors(self) -> Self:
        taken = {sensor.id: "a sensor" for sensor in self.sensors}
        for rig in self.rigs:
            if rig.id in taken:
                raise ValueError(f"rig {rig.id!r}: {taken[rig.id]} has that name; give another")
            taken[rig.id] = "another rig"
            self._ensure_fits(rig)
        counted = Counter(name for rig in self.rigs for name in rig.sensors)
        shared = [name for name, count in counted.items() if count > 1]
        if shared:
            raise ValueError(f"sensor {shared[0]!r} is in two rigs; put it into one")
        return self

    def _ensure_fits(self, rig: RigSettings) -> None:
        for name in rig.sensors:
            sensor = self.sensor(name)
            if sensor is None:
                known = ", ".join(each.id for each in self.sensors)
                raise ValueError(f"rig {rig.id!r} has sensor {name!r}; the station has {known}")
            if sensor.side != self.side_of(rig):
                raise ValueError(
                    f"rig {rig.id!r} is of the {self.side_of(rig)} side but its sensor {name!r} "
                    f"of the {sensor.side}; a rig's sensors look at the same wheel"
                )

    def side_of(self, rig: RigSettings) -> Literal["left", "right"]:
        """Return the side whose wheels a rig sees: its own, or else that of its first sensor."""
        first = self.sensor(rig.sensors[0])
        return rig.side or (first.side if first is not None else "left")

    def anchor_of(self, rig: RigSettings) -> str:
        """Return the sensor whose mounting places a rig: the first that has one, or the first."""
        surveyed = (name for name in rig.sensors if self._mounted(name))
        return rig.anchor or next(surveyed, rig.sensors[0])

    def _mounted(self, sensor_id: str) -> bool:
        sensor = self.sensor(sensor_id)
        return sensor is not None and sensor.mounting is not None

    def rig(self, rig_id: str) -> RigSettings | None:
        """Return the settings of a rig, or None where the station has no such one."""
        return next((rig for rig in self.rigs if rig.id == rig_id), None)

    def rig_with(self, sensor_id: str) -> RigSettings | None:
        """Return the rig that a sensor is in, or None where it is measured by itself."""
        return next((rig for rig in self.rigs if sensor_id in rig.sensors), None)

    def sensor(self, sensor_id: str) -> SensorSettings | None:
        """Return the settings of a sensor, or None where the station has no such one."""
        return next((sensor for sensor in self.sensors if sensor.id == sensor_id), None)
