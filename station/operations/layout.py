"""Where the station keeps its files: one place that knows the names."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from station.errors import InputUnusable
from station.settings import StationSettings
from station.store import sqlite_url


@dataclass(frozen=True, slots=True)
class DataLayout:
    """The folder of the station's data and the names in it."""

    root: Path
    database: str | None = field(default=None, repr=False)
    """URL of the store where it is not a file in the folder; it may hold a password."""

    @classmethod
    def of(cls, settings: StationSettings) -> Self:
        """Return the layout of a station."""
        return cls(settings.data_dir, settings.store_url)

    @property
    def store_url(self) -> str:
        """URL of the store."""
        return self.database or sqlite_url(self.store_file)

    @property
    def store_file(self) -> Path:
        """The file of the store, where it is one."""
        return self.root / "station.sqlite"

    @property
    def jobs_file(self) -> Path:
        """The durable jobs' own database: its locks never hold up the store."""
        return self.root / "jobs.sqlite"

    @property
    def jobs_url(self) -> str:
        """URL of the durable jobs' database."""
        return sqlite_url(self.jobs_file)

    @property
    def worker_lock(self) -> Path:
        """The file that a working worker holds locked."""
        return self.root / "worker.lock"

    @property
    def station_lock(self) -> Path:
        """The file that a running station holds locked."""
        return self.root / "station.lock"

    @property
    def processes_lock(self) -> Path:
        """The file of whose lock every process of a running station holds a share."""
        return self.root / "processes.lock"

    @property
    def sockets_note(self) -> Path:
        """The file that says where a running station has its sockets."""
        return self.root / "sockets"

    @property
    def restarts_note(self) -> Path:
        """The file in which the supervisor tells how often each process was started again."""
        return self.root / "restarts.json"

    @property
    def backup_note(self) -> Path:
        """The file whose age is that of the last backup."""
        return self.root / "last-backup"

    @property
    def uploads(self) -> Path:
        """The folder of recordings that were made elsewhere, relative to the root."""
        return Path("recordings", "uploads")

    def pass_recording(self, pass_id: str, sensor: str) -> Path:
        """Return where a sensor records a pass, relative to the root."""
        return Path("recordings", "passes", pass_id, f"{sensor}.mcap")

    def session_recording(self, session_id: str, sensor: str) -> Path:
        """Return where a sensor records a calibration session, relative to the root."""
        return Path("recordings", "sessions", session_id, f"{sensor}.mcap")

    def ensure(self) -> None:
        """Make the folder where it is missing.

        Raises
        ------
        InputUnusable
            If it cannot be made or written.
        """
        try:
            self.root.mkdir(parents=True, exist_ok=True)
            (self.root / ".writable").touch()
            (self.root / ".writable").unlink()
        except OSError as error:
            raise InputUnusable(
                f"{self.root}: cannot be written ({error.strerror}); "
                "give a data_dir that the station's user may write"
            ) from error
