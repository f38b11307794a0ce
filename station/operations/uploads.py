"""Recordings that were made elsewhere: taken onto the disk, proved, and known from then on.

Nothing that the caller names becomes the name of a file.  What was uploaded before is known again
by its bytes, so an upload that comes twice is one recording.
"""

import hashlib
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from typing import BinaryIO

from sqlalchemy import select

from station.errors import DiskFull, InputUnusable, RecordingUnreadable, StateConflict
from station.operations.collaborators import Station
from station.operations.inspection import Inspected, inspect_apart
from station.storage import GB, free_bytes
from station.store import Action, Actor, Recording, audit, the
from station.store.disposal import recordings_in_use

MAGIC = b"\x89MCAP0\r\n"
_SYNC_BYTES = 16 << 20
"""As much may wait for the disk: a cache full of it would hold up the frames of a train."""

Inspect = Callable[[Path], Inspected]


@dataclass(slots=True)
class Upload:
    """A file that is being taken in."""

    path: Path
    file: BinaryIO
    size_bytes: int
    taken_bytes: int = 0
    unsynced_bytes: int = 0
    start: bytes = b""
    sha256: "hashlib._Hash" = field(default_factory=hashlib.sha256)

    def take(self, piece: bytes) -> None:
        """Write a piece.

        Raises
        ------
        RecordingUnreadable
            As soon as it is clear that this is no recording.
        """
        if len(self.start) < len(MAGIC):
            self.start += piece[: len(MAGIC)]
            if not MAGIC.startswith(self.start[: len(MAGIC)]):
                raise RecordingUnreadable(
                    f"the upload begins with {self.start[:8]!r}: not a recording (MCAP)"
                )
        self.file.write(piece)
        self.sha256.update(piece)
        self.taken_bytes += len(piece)
        self.unsynced_bytes += len(piece)
        if self.unsynced_bytes >= _SYNC_BYTES:
            self.sync()

    def sync(self) -> None:
        """Wait until the disk has it."""
        self.file.flush()
        os.fdatasync(self.file.fileno())
        self.unsynced_bytes = 0


class Uploads:
    """Taking in recordings, one at a time: the space of each is there before it begins."""

    def __init__(self, station: Station, inspect: Inspect = inspect_apart) -> None:
        self._station = station
        self._inspect = inspect
        self._folder = station.layout.root / station.layout.uploads
        self._busy = Lock()

    def take_up(self) -> None:
        """Remove what a dead API process left: parts, and files that no row knows."""
        if not self._folder.is_dir():
            return
        with self._station.store.look() as session:
            known = set(
                session.scalars(select(Recording.path).where(Recording.sha256.is_not(None)))
            )
        for file in self._folder.iterdir():
            if str(self._station.layout.uploads / file.name) not in known:
                file.unlink()

    def begin(self, size_bytes: int) -> Upload:
        """Make a file for an upload of that size.

        Raises
        ------
        InputUnusable
            If it is empty, or larger than the settings allow.
        StateConflict
            If another one is being taken in.
        DiskFull
            If it would not fit, into the quota or onto the disk.
        """
        most_mb = self._station.settings.web.upload_mb
        if not (0 < size_bytes <= most_mb * 10**6):
            raise InputUnusable(
                f"an upload of {size_bytes} bytes; allowed: a recording of at most {most_mb} MB"
            )
        if not self._busy.acquire(blocking=False):
            raise StateConflict("another recording is being uploaded; wait until it is there")
        try:
            self._ensure_space(size_bytes)
            self._folder.mkdir(parents=True, exist_ok=True)
            path = self._folder / f"{self._station.new_id()}.part"
            return Upload(path, path.open("xb"), size_bytes)
        except BaseException:
            self._busy.release()
            raise

    def abandon(self, upload: Upload) -> None:
        """Leave nothing of an upload; a second time, or after its end, changes nothing."""
        if upload.file.closed:
            return
        upload.file.close()
        upload.path.unlink(missing_ok=True)
        self._busy.release()

    def finish(self, upload: Upload, by: Actor) -> tuple[Recording, bool]:
        """Prove an upload and know it from now on; return it, and whether it is new.

        Raises
        ------
        RecordingUnreadable
            If it is no sound recording of one sensor.
        """
        try:
            upload.sync()
            sha256 = upload.sha256.hexdigest()
            known = self._known(sha256)
            if known is not None:
                return known, False
            return self._keep(upload, sha256, self._inspect(upload.path), by), True
        finally:
            self.abandon(upload)

    def remove(self, recording_id: str, by: Actor) -> Recording:
        """Delete an uploaded recording; what was measured or calibrated from it stays.

        Raises
        ------
        NotFound
            If there is none.
        StateConflict
            If it was not uploaded, or is in use.
        """
        station = self._station
        with station.store.change() as session:
            row = the(session, Recording, recording_id)
            if row.sha256 is None:
                raise StateConflict(
                    f"recording {row.id} is the station's own; it makes way by [storage] alone"
                )
            if row.id in recordings_in_use(session):
                raise StateConflict(
                    f"recording {row.id} is what a calibration in force was made from, or one "
                    "that is being solved, or is being replayed"
                )
            if row.deleted_at is None:
                row.deleted_at, row.deleted_why = station.now(), f"deleted by {by.name}"
                audit(session, Action.DELETE, "recording", row.id, by=by, at=station.now())
                (station.layout.root / row.path).unlink(missing_ok=True)
        return row

    def _known(self, sha256: str) -> Recording | None:
        with self._station.store.look() as session:
            return session.scalar(
                select(Recording)
                .where(Recording.sha256 == sha256)
                .where(Recording.deleted_at.is_(None))
                .limit(1)
            )

    def _keep(self, upload: Upload, sha256: str, found: Inspected, by: Actor) -> Recording:
        station, now = self._station, self._station.now()
        name = upload.path.stem
        row = Recording(
            id=f"upload.{name}",
            sensor=found.sensor,
            path=str(station.layout.uploads / f"{name}.mcap"),
            opened_at=now,
            closed_at=now,
            recorded=found.frames,
            lost=found.lost,
            recovered=False,
            summary=f"{found.frames} frames, uploaded by {by.name}",
            files=1,
            sha256=sha256,
        )
        with station.store.change() as session:
            session.add(row)
            after = {"sensor": found.sensor, "sha256": sha256}
            audit(session, Action.ADD, "recording", row.id, by=by, at=now, after=after)
            upload.path.rename(self._folder / f"{name}.mcap")
        return row

    def _ensure_space(self, size_bytes: int) -> None:
        settings = self._station.settings
        quota_gb = min(settings.web.uploads_gb, settings.storage.quota_gb or math.inf)
        used = sum(file.stat().st_size for file in self._folder.glob("*"))
        if used + size_bytes > quota_gb * GB:
            raise DiskFull(
                f"{size_bytes / GB:.2f} GB beside {used / GB:.2f} GB of uploads is more than "
                f"{quota_gb:g} GB; delete some, or raise uploads_gb in [web]"
            )
        free, keep_gb = free_bytes(self._station.layout.root), settings.storage.keep_free_gb
        if free - size_bytes < keep_gb * GB:
            raise DiskFull(
                f"{size_bytes / GB:.2f} GB with {free / GB:.2f} GB free would leave less than "
                f"keep_free_gb = {keep_gb:g}; delete or move recordings"
            )
