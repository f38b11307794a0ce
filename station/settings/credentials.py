"""Secrets that are in files of their own, and neither in the settings nor in an environment.

systemd.exec(5), LoadCredential: a file of the folder `/etc/treadline/credentials` named `key` comes
to the service as `station_key`, for its eyes alone.  Who types a command by hand has no service: it
finds the same file in the folder `credentials` beside the settings, if it may read it.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from station.errors import InputUnusable

CREDENTIALS: Final = ("store_url", "fleet_url", "admin_key", "key")
"""What may be given so; each also as STATION_STORE_URL and so on in the environment, which wins."""
_OF_SERVICE: Final = "CREDENTIALS_DIRECTORY"
_PREFIX: Final = "station_"
_BESIDE_SETTINGS: Final = "credentials"


def credential(
    name: str, settings: Path | None = None, environment: Mapping[str, str] = os.environ
) -> str | None:
    """Return a secret by its name in `CREDENTIALS`; None where nobody gave it.

    Parameters
    ----------
    name
        Of the secret.
    settings
        The file of the settings; None where only environment and service are asked.
    environment
        With what the service manager hands over.

    Raises
    ------
    InputUnusable
        If its file cannot be read, or is empty.
    """
    given = environment.get(f"STATION_{name.upper()}")
    if given:
        return given
    if _OF_SERVICE in environment:
        return _secret_in(Path(environment[_OF_SERVICE], _PREFIX + name), name)
    if settings is not None:
        return _secret_in(settings.parent / _BESIDE_SETTINGS / name, name)
    return None


def _secret_in(file: Path, name: str) -> str | None:
    try:
        text = file.read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        return None
    except PermissionError as error:
        raise InputUnusable(
            f"credential {name}: {file} may not be read by this user; type it as root, or give "
            f"the secret in STATION_{name.upper()}"
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputUnusable(f"credential {name}: cannot be read ({error})") from error
    if not text:
        raise InputUnusable(
            f"credential {name}: its file is empty; put the secret in, or remove it"
        )
    return text
