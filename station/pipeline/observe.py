"""Seeing the target in every picture of the sources, on all cores."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path

from calib import CalibError, Picture, Target, View, observe_target
from station.documents import views_from_points
from station.errors import InputUnusable
from station.pipeline.cores import map_on_all_cores
from station.pipeline.distinct_views import named_apart, without_copies
from station.pipeline.frames import Frame, alike, count_frames, read_frames
from station.pipeline.naming import distinct_names
from station.pipeline.observe_group import PoseShot, observe_group
from station.progress import Progress, silent

_Pose = tuple[Frame, ...]
ObserveTask = tuple[_Pose, Target, Picture | None]

OBSERVE_S = 0.15
"""What seeing the target in one picture takes."""


@dataclass(frozen=True, slots=True)
class Observations:
    """What was seen in the pictures of a calibration.

    Attributes
    ----------
    views
        The pictures in which the target was found.
    left_out
        (name, reason) of the others.
    width, height
        Size of the pictures, px; None where only points were given.
    sensor
        The sensor that recorded them, where a recording says so.
    """

    views: tuple[View, ...]
    left_out: tuple[tuple[str, str], ...]
    width: int | None
    height: int | None
    sensor: str | None

    @property
    def why_left_out(self) -> str:
        """What to add to a refusal for want of pictures: how many were left out, and why."""
        if not self.left_out:
            return ""
        name, reason = self.left_out[0]
        return f"; left out before: {len(self.left_out)}, the first, {name}: {reason}"


_NOTHING = Observations((), (), None, None, None)


def observe_sources(
    sources: Sequence[Path],
    target: Target,
    *,
    laser_off: Sequence[Path] = (),
    progress: Progress = silent,
) -> Observations:
    """Find target and stripe in every picture of the sources, or read them from points.csv.

    A picture in which the target is not found, or that is a copy of another, is named in
    `left_out`, never fatal.

    Raises
    ------
    InputUnusable
        If a source cannot be used or is given twice, the pictures differ in size or sensor, or the
        laser-off pictures do not pair with the others.
    RecordingUnreadable
        If a recording is damaged.
    """
    points_files = [path for path in sources if path.suffix.lower() == ".csv"]
    pictures = [path for path in sources if path not in points_files]
    if not sources:
        raise InputUnusable("no SOURCE given; give recordings, pictures, folders or a points.csv")
    of_files = [
        (label, _views_of_file(path, target))
        for label, path in zip(distinct_names(points_files), points_files, strict=True)
    ]
    seen = _NOTHING if not pictures else _observe_pictures(pictures, target, laser_off, progress)
    names = [view.name for view in seen.views] + [name for name, _ in seen.left_out]
    views, copies = without_copies([*named_apart(of_files, names), *seen.views])
    return replace(seen, views=tuple(views), left_out=(*seen.left_out, *copies))


def _views_of_file(path: Path, target: Target) -> list[View]:
    try:
        # Spreadsheets begin such a file with a mark of the byte order.
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputUnusable(
            f"{path}: cannot be read ({error.strerror}); give a points.csv"
        ) from error
    except UnicodeDecodeError as error:
        raise InputUnusable(f"{path}: not text in UTF-8; save it as UTF-8") from error
    return views_from_points(text, target, name=str(path))


def _observe_pictures(
    sources: Sequence[Path],
    target: Target,
    laser_off: Sequence[Path],
    progress: Progress,
) -> Observations:
    total = count_frames(sources)
    views: list[View] = []
    left_out: list[tuple[str, str]] = []
    names: list[str] = []
    first: Frame | None = None

    def tasks() -> Iterator[ObserveTask]:
        nonlocal first
        for pose, off in _paired(sources, laser_off):
            first = first or pose[0]
            for frame in pose:
                alike(frame, first)
            names.append(pose[0].name)
            yield pose, target, off

    for done, seen in enumerate(
        map_on_all_cores(observe_pose, tasks(), count=total, seconds_each=OBSERVE_S), start=1
    ):
        progress(min(done / total, 1.0), f"picture {done} of {total}")
        if isinstance(seen, View):
            views.append(seen)
        else:
            left_out.append((names[done - 1], seen))
    if first is None:
        raise InputUnusable(f"{sources[0]}: no frame in it; give a source with pictures")
    height, width = first.picture.shape
    return Observations(tuple(views), tuple(left_out), width, height, first.sensor)


def _paired(
    sources: Sequence[Path], laser_off: Sequence[Path]
) -> Iterator[tuple[_Pose, Picture | None]]:
    if not laser_off:
        for pose in poses_of(read_frames(sources)):
            yield pose, None
        return
    dark = read_frames(laser_off)
    count = 0
    for count, frame in enumerate(read_frames(sources), start=1):
        if frame.exposure is not None:
            raise InputUnusable(
                f"{frame.name} is of an exposure sequence, which has its own laser-off pictures; "
                "leave --laser-off out"
            )
        pair = next(dark, None)
        if pair is None:
            raise InputUnusable(
                f"only {count - 1} laser-off pictures; allowed: one for every picture, same order"
            )
        yield (frame,), alike(pair, frame).picture
    if next(dark, None) is not None:
        raise InputUnusable(
            f"more laser-off pictures than the {count} pictures; allowed: one for every picture"
        )


def poses_of(frames: Iterable[Frame]) -> Iterator[_Pose]:
    """Yield the frames of each pose together: a group of an exposure sequence, or one frame."""
    for pose, members in groupby(frames, key=_pose_key):
        if pose is None:
            yield from ((frame,) for frame in members)
        else:
            yield tuple(members)


def _pose_key(frame: Frame) -> tuple[str, int] | None:
    return None if frame.exposure is None else (frame.source, frame.exposure.group)


def observe_pose(task: ObserveTask) -> View | str:
    """Return what the pictures of one pose show together, or why they show no target."""
    pose, target, laser_off = task
    name = pose[0].name
    shots = [
        PoseShot(one.name, one.picture, one.exposure) for one in pose if one.exposure is not None
    ]
    try:
        if shots:
            return observe_group(shots, target)
        return observe_target(pose[0].picture, target, name=name, laser_off=laser_off)
    except CalibError as error:
        return str(error).removeprefix(f"{name}: ")
