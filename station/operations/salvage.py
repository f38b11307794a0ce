"""Making whole what a capture process left when it died."""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from station.errors import InputUnusable, StateConflict, StationError
from station.operations.collaborators import FileAccount, Salvaged
from station.recording import (
    ACCOUNTING,
    CONTINUED_IN,
    ListedFrame,
    active_path,
    info,
    left_behind,
    list_frames,
    recover,
)

_PATIENCE_S = 15.0
_PAUSE_S = 0.1


def salvage_recording(path: Path, sleep: Callable[[float], None] = time.sleep) -> Salvaged | None:
    """Return what is recorded under a path, finished where it was not; None where nothing is.

    The recorder of a dead capture process closes the file by itself: as long as it is at it, it
    is waited for.

    Raises
    ------
    StateConflict
        If the file is still being written after 15 s.
    InputUnusable, RecordingError
        If nothing can be read from it.
    """
    for _, part in left_behind(path):
        _make_whole(part, sleep)
    parts = [part for _, part in left_behind(path)]
    if not parts:
        return None
    found = [info(part) for part in parts]
    frames = sum(sensor.frames for one in found for sensor in one.sensors)
    said = [one.metadata.get(ACCOUNTING, {}) for one in found]
    last = _last_frame(parts, frames)
    files = "" if len(parts) == 1 else f" in {len(parts)} files"
    return Salvaged(
        frames=frames,
        summary=f"{frames} frames saved{files}",
        files=len(parts),
        account=_account_in(said[-1], frames),
        # A file that goes on in a next one says so, unless whoever wrote it did not live to.
        interruptions=sum(CONTINUED_IN not in each for each in said[:-1]),
        last_frame_id=None if last is None else last.frame_id,
        last_frame_ns=None if last is None else last.host_time_ns,
    )


def _last_frame(parts: Sequence[Path], frames: int) -> ListedFrame | None:
    try:
        return next(iter(list_frames(parts, after=max(frames - 1, 0), most=1)), None)
    except StationError:
        return None  # what is whole of it counts all the same


def _account_in(said: Mapping[str, str], frames: int) -> FileAccount | None:
    """Return the account that a recording ends with, if it has one and that is of these frames.

    A file that goes on in a next one says of itself alone: no `lost` is in it.
    """
    try:
        lost, repeated, refused = (int(said[name]) for name in ("lost", "repeated", "refused"))
        triggered = None if said["triggered"] == "None" else int(said["triggered"])
        if int(said["recorded"]) != frames:
            return None
    except (KeyError, ValueError):
        return None
    return FileAccount(triggered, lost, repeated, refused, complete=said.get("complete") == "True")


def _make_whole(path: Path, sleep: Callable[[float], None]) -> None:
    for _ in range(int(_PATIENCE_S / _PAUSE_S)):
        if not active_path(path).exists():
            return
        try:
            recover(active_path(path))
        except StateConflict:
            sleep(_PAUSE_S)
        except InputUnusable:
            if not path.exists():
                raise
            # The recorder gave the file its name between the look and the call.
    if active_path(path).exists():
        raise StateConflict(
            f"{path} is still being written after {_PATIENCE_S:.0f} s; is its disk stuck?"
        )
