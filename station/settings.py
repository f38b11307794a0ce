"""The station's settings: one typed tree, read once at start from TOML and the environment."""

import tomllib
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    model_validator,
)
from pydantic_settings import (
    BaseSettings,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

from station.errors import InputUnusable

SensorId = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


class MountingSettings(_Section):
    """How a sensor sits beside the track: the survey of its installation."""

    rotation_vector: tuple[float, float, float]
    """Rotation vector of rig_from_camera, rad."""
    translation_mm: tuple[float, float, float]
    """Translation of rig_from_camera: the camera's place in the rig frame, mm."""
    wheel_radius_mm: float = Field(default=420.0, gt=100.0, lt=1000.0)
    """Nominal radius of the wheels at the tape circle, mm."""


class SensorSettings(_Section):
    """One sensor: a camera, its laser, and where it stands."""

    id: SensorId
    """Name of the sensor: lower-case letters, digits, - and _."""
    address: str
    """IP address of the camera."""
    side: Literal["left", "right"] = "left"
    """The side of the train whose wheels it sees."""
    trigger: Literal["free", "software", "Line1"] = "Line1"
    """What starts an exposure in a pass."""
    exposure_us: float | None = Field(default=None, gt=0.0)
    """Exposure time, µs; the camera's own where absent."""
    gain_db: float | None = None
    """Gain, dB; the camera's own where absent."""
    frame_rate_hz: float = Field(default=53.0, gt=0.0)
    """Frames a second in free run."""
    packet_size: int = Field(default=9000, ge=576, le=16384)
    """GVSP packet size, bytes; the path must carry it."""
    ring_slots: int = Field(default=128, ge=4, le=1024)
    """Frames the memory between camera and disk holds: 128 bridge 2.4 s of a slow disk at 53 Hz."""
    mounting: MountingSettings | None = None
    """Where the sensor stands; wheel sections need it."""


class StationSettings(_Section):
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


def load_settings(path: Path) -> StationSettings:
    """Read the settings from a TOML file; variables ``STATION_NAME`` of the environment win.

    A relative `data_dir` counts from the folder of the file.

    Raises
    ------
    InputUnusable
        If the file cannot be read, is not TOML, or holds a setting that is not allowed.
    """

    class Sources(BaseSettings, StationSettings):
        model_config = SettingsConfigDict(
            env_prefix="STATION_", env_nested_delimiter="__", extra="forbid", toml_file=path
        )

        @classmethod
        def settings_customise_sources(
            cls,
            settings_cls: type[BaseSettings],
            init_settings: PydanticBaseSettingsSource,
            env_settings: PydanticBaseSettingsSource,
            dotenv_settings: PydanticBaseSettingsSource,
            file_secret_settings: PydanticBaseSettingsSource,
        ) -> tuple[PydanticBaseSettingsSource, ...]:
            return env_settings, TomlConfigSettingsSource(settings_cls)

    if not path.is_file():
        raise InputUnusable(f"{path}: no such settings file; give one by --config station.toml")
    try:
        sources = Sources()  # type: ignore[call-arg]  # its fields come from file and environment
        found = StationSettings.model_validate(sources.model_dump())
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "settings"
        raise InputUnusable(f"{path}: {where}: {first['msg']}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputUnusable(f"{path}: not a TOML file: {error}") from error
    except OSError as error:
        raise InputUnusable(f"{path}: cannot be read ({error.strerror})") from error
    return found.model_copy(update={"data_dir": (path.parent / found.data_dir).resolve()})
