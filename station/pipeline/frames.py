"""Frames of any SOURCE: a recording, a picture, a folder of pictures."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from calib import Picture
from station.errors import InputUnusable
from station.pictures import RECORDING_SUFFIX, pictures_of, read_picture
from station.pipeline.exposures import Exposure, exposures_in
from station.pipeline.naming import distinct_names
from station.recording import frames as recorded_frames
from station.recording import info as recording_info
from station.recording import whole_recordings


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One picture and where it came from.

    No two frames of the sources read together have the same `name`: where files share theirs, it
    has as much of their folders as tells them apart. `number` is its id in a recording, or its
    place among pictures; `time_ns` is the camera's UTC time where known; `sensor` is the
    recording's sensor where known; `exposure` is how it was taken, where it is of an exposure
    sequence.
    """

    name: str
    source: str
    number: int
    picture: Picture
    sensor: str | None = None
    time_ns: int | None = None
    exposure: Exposure | None = None


def read_frames(sources: Sequence[Path]) -> Iterator[Frame]:
    """Yield the frames of all sources, one at a time.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    groups = files_by_source(sources)
    names = iter(distinct_names([path for group in groups for path in group]))
    for source, group in zip(sources, groups, strict=True):
        if is_recording(source):
            for part in group:
                yield from _frames_of_recording(part, next(names))
        else:
            yield from _frames_of_pictures(group, names)


def files_of(sources: Sequence[Path]) -> list[Path]:
    """Return the files that sources stand for: pictures, and all files of a recording, in order.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged, or a file that it goes on in is missing.
    """
    return [path for group in files_by_source(sources) for path in group]


def files_by_source(sources: Sequence[Path]) -> list[Sequence[Path]]:
    """Return the files of each source; none where it is a later file of another one."""
    recordings = whole_recordings([source for source in sources if is_recording(source)])
    parts = {group[0]: group for group in recordings}
    return [
        parts.get(source, ()) if is_recording(source) else pictures_of(source) for source in sources
    ]


def is_recording(source: Path) -> bool:
    """Return whether a source is a recording, by its name."""
    return source.suffix.lower() == RECORDING_SUFFIX


def _frames_of_recording(path: Path, name: str) -> Iterator[Frame]:
    times: Counter[int] = Counter()
    exposures = exposures_in(path)
    for recorded in recorded_frames(path):
        times[recorded.frame_id] += 1
        # A camera that was started again, and a second one, number from 1 again.
        again = f".{times[recorded.frame_id]}" if times[recorded.frame_id] > 1 else ""
        yield Frame(
            name=f"{name}#{recorded.frame_id}{again}",
            source=path.name,
            number=recorded.frame_id,
            picture=recorded.picture,
            sensor=recorded.sensor,
            time_ns=recorded.camera_time_ns,
            exposure=exposures.get((recorded.frame_id, times[recorded.frame_id])),
        )


def _frames_of_pictures(paths: Sequence[Path], names: Iterator[str]) -> Iterator[Frame]:
    for place, path in enumerate(paths):
        yield Frame(name=next(names), source=path.name, number=place, picture=read_picture(path))


def count_frames(sources: Sequence[Path]) -> int:
    """Return how many frames `read_frames` will yield, at least 1, without reading pictures.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    files = files_of(sources)
    return max(sum(_frames_recorded(path) if is_recording(path) else 1 for path in files), 1)


def _frames_recorded(path: Path) -> int:
    return sum(sensor.frames for sensor in recording_info(path).sensors)


def alike(frame: Frame, first: Frame) -> Frame:
    """Return `frame` after checking that it has the size of `first` and is of the same sensor.

    Raises
    ------
    InputUnusable
        If it has not or is not.
    """
    if None not in (frame.sensor, first.sensor) and frame.sensor != first.sensor:
        raise InputUnusable(
            f"{frame.name} is of sensor {frame.sensor} but {first.name} is of {first.sensor}; "
            "allowed: recordings of one sensor"
        )
    if frame.picture.shape != first.picture.shape:
        (height, width), (first_height, first_width) = frame.picture.shape, first.picture.shape
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but {first.name} is {first_width} x "
            f"{first_height}; allowed: pictures of one camera at one resolution"
        )
    return frame
