"""Frames of any SOURCE: a recording, a picture, a folder of pictures."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from calib import Picture
from station.errors import InputUnusable
from station.pictures import RECORDING_SUFFIX, pictures_of, read_picture
from station.recording import frames as recorded_frames
from station.recording import info as recording_info


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One picture and where it came from.

    `number` is its id in a recording, or its place among pictures; `time_ns` is the camera's UTC
    time where known; `sensor` is the recording's sensor where known.
    """

    name: str
    source: str
    number: int
    picture: Picture
    sensor: str | None = None
    time_ns: int | None = None


def read_frames(sources: Sequence[Path]) -> Iterator[Frame]:
    """Yield the frames of all sources, one at a time.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    for source in sources:
        if source.suffix.lower() == RECORDING_SUFFIX:
            yield from _frames_of_recording(source)
        else:
            yield from _frames_of_pictures(source)


def _frames_of_recording(path: Path) -> Iterator[Frame]:
    if not path.exists():
        raise InputUnusable(f"{path}: no such file; give a recording that exists")
    for recorded in recorded_frames(path):
        yield Frame(
            name=f"{path.name}#{recorded.frame_id}",
            source=path.name,
            number=recorded.frame_id,
            picture=recorded.picture,
            sensor=recorded.sensor,
            time_ns=recorded.camera_time_ns,
        )


def _frames_of_pictures(source: Path) -> Iterator[Frame]:
    for place, path in enumerate(pictures_of(source)):
        yield Frame(name=path.name, source=path.name, number=place, picture=read_picture(path))


def count_frames(sources: Sequence[Path]) -> int:
    """Return how many frames `read_frames` will yield, at least 1, without reading pictures.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    count = 0
    for source in sources:
        recorded = source.suffix.lower() == RECORDING_SUFFIX
        count += _frames_recorded(source) if recorded else len(pictures_of(source))
    return max(count, 1)


def _frames_recorded(path: Path) -> int:
    return sum(sensor.frames for sensor in recording_info(path).sensors)


def same_size_as(frame: Frame, first: Frame) -> Frame:
    """Return `frame` after checking that it has the size of `first`.

    Raises
    ------
    InputUnusable
        If the sizes differ.
    """
    if frame.picture.shape != first.picture.shape:
        (height, width), (first_height, first_width) = frame.picture.shape, first.picture.shape
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but {first.name} is {first_width} x "
            f"{first_height}; allowed: pictures of one camera at one resolution"
        )
    return frame
