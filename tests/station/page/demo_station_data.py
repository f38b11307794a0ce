"""The data of the demo station in a folder: made once, kept, copied for whoever plays with it."""

import json
import os
import shutil
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

import cv2
from demo_station_desk import Desk, days_before
from demo_station_pictures import Pictures
from demo_station_settings import write_settings
from demo_station_story import Told, tell
from demo_station_truth import Truth
from demo_station_worker import Clock

from station.settings import load_settings

SEED = 20261
_WEEKS = 6
_TOLD = "told.json"


@dataclass(frozen=True)
class DemoData:
    """A folder with the station's data, what its cameras may show, and what was told of it."""

    folder: Path
    told: Told

    @classmethod
    def made(cls, folder: Path, *, seed: int = SEED, end: datetime | None = None) -> "DemoData":
        """Make it in a folder that is empty or not there; the story ends now, to the minute."""
        with _one_core():
            return cls._made(folder, seed, end)

    @classmethod
    def _made(cls, folder: Path, seed: int, end: datetime | None) -> "DemoData":
        end = end or datetime.now(UTC).replace(second=0, microsecond=0)
        truth = Truth(seed)
        pictures = Pictures.rendered(truth)
        folder.mkdir(parents=True, exist_ok=True)
        pictures.keep(folder / "films")
        settings = load_settings(write_settings(folder / "station.toml", truth))
        desk = Desk(settings, pictures, Clock(days_before(end, 7.0 * _WEEKS)))
        told = tell(desk, end)
        desk.store.close()
        # Last: a folder without it was left half made.
        (folder / _TOLD).write_text(json.dumps(asdict(told), indent=1), encoding="utf-8")
        return cls(folder, told)

    @classmethod
    def kept(cls, folder: Path) -> "DemoData":
        """Return what is in a folder; make it where it is not, or was left half made."""
        if (folder / _TOLD).is_file():
            return cls(folder, Told(**json.loads((folder / _TOLD).read_text(encoding="utf-8"))))
        shutil.rmtree(folder, ignore_errors=True)
        half = folder.with_name(f"{folder.name}.{os.getpid()}")
        shutil.rmtree(half, ignore_errors=True)
        cls.made(half)
        half.rename(folder)
        return cls.kept(folder)

    @property
    def films(self) -> Path:
        """The folder of what the cameras show."""
        return self.folder / "films"

    def copy_to(self, folder: Path) -> Path:
        """Copy the station's data beside a settings file to come; return the data's folder.

        Recordings are never written into again: a link to the same file is as good as a copy.
        """
        copy = folder / "data"
        shutil.copytree(self.folder / "data", copy, copy_function=_link_or_copy)
        return copy


@contextmanager
def _one_core() -> Generator[None]:
    """Leave the other cores to others, as the worker does; afterwards as it was."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


def _link_or_copy(source: str, target: str) -> str:
    if source.endswith(".mcap"):
        try:
            os.link(source, target)
        except OSError:  # another file system
            return shutil.copy2(source, target)
        return target
    return shutil.copy2(source, target)
