"""The disk, the files of the store, the last backup, the processes: for Prometheus."""

import shutil
import time
from collections.abc import Iterable
from pathlib import Path

from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from station.api.families import counters, gauge, gauges
from station.operations import Station
from station.processes.tally import read_tally
from station.storage import GB, recordings_bytes
from station.store import file_of
from station.store.watched import database_bytes

_WALK_EVERY_S = 60.0
"""The folder of recordings may hold a hundred thousand files."""


class HostCollector(Collector):
    """Asks the file system."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._layout = station.layout
        self._recordings_bytes = 0
        self._walk_at_s = 0.0

    def collect(self) -> Iterable[Metric]:
        disk = shutil.disk_usage(self._layout.root)
        yield gauge("station_disk_free_bytes", "Space left for data.", disk.free)
        yield gauge("station_disk_size_bytes", "Size of the disk for data.", disk.total)
        yield gauge(
            "station_recordings_bytes",
            "What all recordings take, as of the last minute.",
            self._walked(),
        )
        quota_gb = self._station.settings.storage.quota_gb
        yield gauge(
            "station_recordings_quota_bytes",
            "What they may take before measured ones make way; absent without quota_gb.",
            None if quota_gb is None else quota_gb * GB,
        )
        yield gauges(
            "station_store_bytes", "Size of the store, file by file.", ["file"], self._store_bytes()
        )
        yield gauge(
            "station_backup_age_seconds",
            "Time since `station backup` last ended well; absent before the first.",
            self._backup_age_s(),
        )
        restarts = read_tally(self._layout.restarts_note)
        yield counters(
            "station_process_restarts",
            "Times that a process ended and was started again, since the station was started.",
            ["process"],
            {(name,): float(count) for name, count in restarts.items()},
        )

    def _walked(self) -> float:
        if time.monotonic() >= self._walk_at_s:
            self._recordings_bytes = recordings_bytes(self._layout.root)
            self._walk_at_s = time.monotonic() + _WALK_EVERY_S
        return float(self._recordings_bytes)

    def _store_bytes(self) -> dict[tuple[str, ...], float]:
        main = file_of(self._layout.store_url)
        files = {"jobs": self._layout.jobs_file} | ({} if main is None else {"store": main})
        sizes: dict[tuple[str, ...], float] = {(name,): _size(file) for name, file in files.items()}
        sizes |= {(f"{name}_wal",): _size(_wal(file)) for name, file in files.items()}
        if main is None:
            with self._station.store.look() as session:
                sizes[("store",)] = float(database_bytes(session) or 0)
        return sizes

    def _backup_age_s(self) -> float | None:
        try:
            made_s = self._layout.backup_note.stat().st_mtime
        except FileNotFoundError:
            return None
        return self._station.now().timestamp() - made_s


def _wal(file: Path) -> Path:
    """Return where SQLite writes before it writes into the file."""
    return file.with_name(f"{file.name}-wal")


def _size(file: Path) -> float:
    return float(file.stat().st_size) if file.exists() else 0.0
