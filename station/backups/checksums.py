"""The SHA-256 beside a file, as `sha256sum -c` reads it."""

import hashlib
from pathlib import Path

from station.errors import InputUnusable


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def beside(path: Path) -> Path:
    """Return where the checksum of a file stands."""
    return path.with_name(f"{path.name}.sha256")


def write_checksum(path: Path) -> str:
    """Write the checksum of a file beside it, and return it."""
    digest = digest_of(path)
    beside(path).write_text(f"{digest}  {path.name}\n")
    return digest


def ensure_checksum(path: Path) -> str:
    """Return the checksum of a file that is as it was when its checksum was written.

    Raises
    ------
    InputUnusable
        If the file or its checksum is not there, or they do not fit.
    """
    try:
        kept = beside(path).read_text().partition(" ")[0]
        found = digest_of(path)
    except OSError as error:
        raise InputUnusable(
            f"{error.filename}: cannot be read ({error.strerror}); "
            f"give a backup with its {beside(path).name} beside it"
        ) from error
    except UnicodeDecodeError as error:
        raise InputUnusable(f"{beside(path)}: not a file of `station backup`") from error
    if found != kept:
        raise InputUnusable(
            f"{path}: SHA-256 {found[:12]}…, {beside(path).name} says {kept[:12]}…: "
            "it changed since it was written; give another backup"
        )
    return found
