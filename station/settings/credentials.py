"""Secrets that a service manager hands over in files, for this service's eyes alone.

systemd.exec(5), LoadCredential: a file of the folder `/etc/treadline/credentials` named `key` comes
as `station_key`.  An environment is seen by more people than such a file.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from station.errors import InputUnusable

CREDENTIALS: Final = ("store_url", "fleet_url", "admin_key", "key")
"""What may be given so; each also as STATION_STORE_URL and so on in the environment, which wins."""
_FOLDER: Final = "CREDENTIALS_DIRECTORY"
_PREFIX: Final = "station_"


def credential(name: str, environment: Mapping[str, str] = os.environ) -> str | None:
    """Return a secret by its name in `CREDENTIALS`; None where nobody gave it.

    Raises
    ------
    InputUnusable
        If its file cannot be read, or is empty.
    """
    given = environment.get(f"STATION_{name.upper()}")
    if given:
        return given
    folder = environment.get(_FOLDER)
    if folder is None:
        return None
    try:
        text = Path(folder, _PREFIX + name).read_text(encoding="utf-8").strip()
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise InputUnusable(f"credential {name}: cannot be read ({error})") from error
    if not text:
        raise InputUnusable(
            f"credential {name}: its file is empty; put the secret in, or remove it"
        )
    return text
