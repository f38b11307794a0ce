"""Which frame each picture of a calibration is: points.csv names them by file and frame id."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from station.errors import StationError
from station.operations.collaborators import Station
from station.operations.downloads import recording_files
from station.pipeline import distinct_names
from station.recording import list_frames
from station.store import Calibration, RigCalibration, the

_MOST = 5000
"""Frames of a file: a session has far fewer, and a recording of a pass is no calibration."""


@dataclass(frozen=True, slots=True)
class FramePlace:
    """A frame of a recording, by its number from 1."""

    recording: str
    number: int


def pictures_of(station: Station, calibration_id: str) -> Mapping[str, FramePlace]:
    """Return the frames of a calibration's pictures by the pictures' names.

    Those of recordings that were deleted, or cannot be read, are left out: what was found in them
    is still known.

    Raises
    ------
    NotFound
        If there is no such calibration.
    """
    with station.store.look() as session:
        row = the(session, Calibration, calibration_id)
        names = list(row.recording_ids.get("recordings", []))
    return _pictures_in(station, names)


def rig_pictures_of(station: Station, calibration_id: str, sensor: str) -> Mapping[str, FramePlace]:
    """Return the frames of a sensor's pictures in the calibration of its rig, as `pictures_of`.

    Raises
    ------
    NotFound
        If there is no such calibration.
    """
    with station.store.look() as session:
        ordered = the(session, RigCalibration, calibration_id).ordered or {}
    return _pictures_in(station, list(ordered.get("recordings", {}).get(sensor, [])))


def _pictures_in(station: Station, names: Sequence[str]) -> Mapping[str, FramePlace]:
    files = {name: _files(station, name) for name in names}
    labels = iter(distinct_names([path for parts in files.values() for path in parts]))
    return {
        picture: place
        for name, parts in files.items()
        for picture, place in _named(name, parts, labels)
    }


def _files(station: Station, recording_id: str) -> Sequence[Path]:
    try:
        return recording_files(station, recording_id)
    except StationError:  # deleted, or gone
        return ()


def _named(
    recording_id: str, files: Sequence[Path], labels: Iterator[str]
) -> Iterator[tuple[str, FramePlace]]:
    before = 0
    for path in files:
        label, times = next(labels), Counter[int]()
        try:
            frames = list_frames([path], after=0, most=_MOST)
        except StationError:
            continue
        for place, frame in enumerate(frames, start=before + 1):
            times[frame.frame_id] += 1
            # As the pipeline names them: a camera that was started again numbers from 1 again.
            again = f".{times[frame.frame_id]}" if times[frame.frame_id] > 1 else ""
            yield f"{label}#{frame.frame_id}{again}", FramePlace(recording_id, place)
        before += len(frames)
