"""How much the disk still takes: passes at once, and days at the rate of the last ones."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

from sqlalchemy.orm import Session

from station.capture import CaptureStatus
from station.operations import Station
from station.storage import GB, expected_of_pass
from station.store.watched import frames_kept_since

WATCHED: Final = timedelta(days=7)
"""The rate is that of so long: week-ends have fewer trains."""
_PLANNED: Final = timedelta(days=3650)


@dataclass(frozen=True, slots=True)
class DiskNow:
    """The disk of the recordings."""

    free_bytes: int
    total_bytes: int
    kept_bytes: int
    """What no recording may use up."""
    pass_bytes: int
    """The longest pass, all sensors together."""
    per_day_bytes: float
    """What the last days' recordings took, a day."""
    makes_way: bool
    """Whether measured recordings make way when it is full."""

    @property
    def usable_bytes(self) -> int:
        """What recordings may use."""
        return max(self.free_bytes - self.kept_bytes, 0)

    @property
    def passes_left(self) -> int | None:
        """How many of the longest passes it takes; None where their size is not known."""
        return None if self.pass_bytes <= 0 else self.usable_bytes // self.pass_bytes

    @property
    def lasts_s(self) -> float | None:
        """How long it takes what comes, at that rate; None where nothing came."""
        if self.per_day_bytes <= 0.0:
            return None
        return self.usable_bytes / self.per_day_bytes * timedelta(days=1).total_seconds()

    @property
    def outlasts(self) -> bool:
        """Whether it takes longer than anybody plans for."""
        return self.lasts_s is not None and self.lasts_s > _PLANNED.total_seconds()


def disk_now(
    station: Station, session: Session, statuses: Mapping[str, CaptureStatus], now: datetime
) -> DiskNow | None:
    """Return how full the disk is; None where it does not tell."""
    try:
        disk = shutil.disk_usage(station.layout.root)
    except OSError:
        return None
    storage = station.settings.storage
    expected = [
        expected_of_pass(sensor, storage, picture_bytes(statuses.get(sensor.id)))
        for sensor in station.sensors
    ]
    frame_bytes = {each.sensor: each.size_bytes / max(each.frames, 1) for each in expected}
    frames = frames_kept_since(session, now - WATCHED)
    came = sum(count * frame_bytes.get(sensor, 0.0) for sensor, count in frames.items())
    return DiskNow(
        free_bytes=disk.free,
        total_bytes=disk.total,
        kept_bytes=round(max(storage.keep_free_gb * GB, storage.reserve_mb * 1e6)),
        pass_bytes=sum(each.size_bytes for each in expected),
        per_day_bytes=came / (WATCHED / timedelta(days=1)),
        makes_way=storage.quota_gb is not None or storage.keep_days is not None,
    )


def picture_bytes(status: CaptureStatus | None) -> int | None:
    """Return the size of a camera's pictures; None where it does not say."""
    if status is None:
        return None
    try:
        return int(status.camera["width"]) * int(status.camera["height"])
    except (KeyError, ValueError):
        return None
