"""The host and the software on it."""

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Final

from station.api import API_VERSION
from station.operations import DataLayout
from station.software import SOFTWARE
from station.store import file_of, revision_of

_PACKAGES: Final = (
    "numpy",
    "scipy",
    "opencv-python-headless",
    "mcap",
    "fastapi",
    "sqlalchemy",
    "dbos",
)


@dataclass(frozen=True, slots=True)
class Version:
    """What runs here, and which of it."""

    name: str
    version: str


def versions(layout: DataLayout) -> Sequence[Version]:
    """Return what runs here; of the store its kind alone, as its address may hold a password."""
    name, _, number = SOFTWARE.partition(" ")
    return (
        Version(name, number),
        Version("API", f"v1, {API_VERSION}"),
        Version("Python", platform.python_version()),
        Version(platform.system(), platform.release()),
        Version(_database(layout), f"tables {revision_of(layout.store_url)}"),
        *(Version(package, version(package)) for package in _PACKAGES),
    )


def _database(layout: DataLayout) -> str:
    return "PostgreSQL" if file_of(layout.store_url) is None else "SQLite"
