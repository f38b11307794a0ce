"""Seeing the boards of a rigid target in the pictures that several sensors took of it."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from calib import LaserSensor, Target
from station.documents import views_from_points
from station.errors import InputUnusable
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import Frame, count_frames, read_frames
from station.pipeline.observe import OBSERVE_S, ObserveTask, observe_pose, poses_of
from station.pipeline.showings import SeenPose
from station.progress import Progress, silent


def observe_showings(
    sources: Mapping[str, Path],
    boards: Mapping[str, Target],
    sensors: Mapping[str, LaserSensor],
    *,
    progress: Progress = silent,
) -> dict[str, list[SeenPose]]:
    """Return what each sensor saw, pose by pose, those without the board among them.

    Parameters
    ----------
    sources
        Of each sensor: a recording, pictures, or a points.csv.
    boards
        The board that each sensor sees.
    sensors
        The sensors as they are calibrated, by name.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or pictures are not of the sensor's size.
    RecordingUnreadable
        If a recording is damaged.
    """
    seen = {}
    for place, (sensor, source) in enumerate(sources.items()):
        if source.suffix.lower() == ".csv":
            seen[sensor] = _poses_of_file(source, boards[sensor])
            continue

        def report(done: float, what: str, first: int = place, name: str = sensor) -> None:
            progress((first + done) / len(sources), f"{name}: {what}")

        seen[sensor] = _poses_of_pictures(source, boards[sensor], sensors[sensor], report)
    return seen


def _poses_of_file(path: Path, board: Target) -> list[SeenPose]:
    views = views_from_points(_text(path), board, name=str(path))
    return [SeenPose(view.name, view) for view in views]


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise InputUnusable(f"{path}: cannot be read as text; give a points.csv") from error


def _poses_of_pictures(
    source: Path, board: Target, sensor: LaserSensor, progress: Progress
) -> list[SeenPose]:
    total = count_frames([source])
    poses: list[tuple[str, int | None]] = []

    def tasks() -> Iterator[ObserveTask]:
        for frames in poses_of(read_frames([source])):
            _ensure_size(frames, sensor)
            poses.append((frames[0].name, frames[0].time_ns))
            yield frames, board, None

    seen = []
    answers = map_on_all_cores(observe_pose, tasks(), count=total, seconds_each=OBSERVE_S)
    for done, answer in enumerate(answers, start=1):
        progress(min(done / total, 1.0), f"picture {done} of {total}")
        name, time_ns = poses[done - 1]
        seen.append(SeenPose(name, answer, time_ns))
    if not seen:
        raise InputUnusable(f"{source}: no frame in it; give a source with pictures")
    return seen


def _ensure_size(frames: Sequence[Frame], sensor: LaserSensor) -> None:
    camera = sensor.camera
    for frame in frames:
        height, width = frame.picture.shape
        if (width, height) != (camera.width, camera.height):
            raise InputUnusable(
                f"{frame.name} is {width} x {height} px but its sensor's calibration is of "
                f"{camera.width} x {camera.height}; give the calibrations in the order of the "
                "sources"
            )
