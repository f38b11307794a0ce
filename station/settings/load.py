"""Reading the settings from TOML and the environment."""

import tomllib
from pathlib import Path

from pydantic import ValidationError
from pydantic_settings import (
    BaseSettings,
    PydanticBaseSettingsSource,
    SettingsConfigDict,
    TomlConfigSettingsSource,
)

from station.errors import InputUnusable
from station.settings.credentials import credential
from station.settings.station import StationSettings


def load_settings(path: Path) -> StationSettings:
    """Read the settings from a TOML file; variables ``STATION_NAME`` of the environment win.

    The URLs of the store and the fleet, which may hold passwords, may also come as credentials of
    the service; that of the store also from the folder `credentials` beside the file, for without
    it another store would be taken for the station's.

    Relative paths in it (data, reference, certificate, key) count from the folder of the file.

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

    try:
        if not path.is_file():
            raise InputUnusable(f"{path}: no such settings file; give one by --config station.toml")
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
    reference = path.parent / found.reference
    beside: dict[str, object] = {
        "store_url": credential("store_url", path) or found.store_url,
        "data_dir": (path.parent / found.data_dir).resolve(),
        "recalibration": found.recalibration.beside(path.parent),
    }
    if reference.is_file():
        beside["reference"] = str(reference.resolve())
    if found.fleet is not None:
        url = credential("fleet_url") or found.fleet.url
        beside["fleet"] = found.fleet.model_copy(update={"url": url})
    if found.tls is not None:
        beside["tls"] = found.tls.beside(path.parent)
    return found.model_copy(update=beside).read_from(path.resolve())
