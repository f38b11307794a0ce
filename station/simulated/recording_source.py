"""A camera that shows a recording again."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from calib import Picture
from station.errors import InputUnusable
from station.recording import RecordedFrame, frames, id_after, ids_skipped, info, parts_of
from station.simulated.gvsp import LAST_BLOCK_ID
from station.simulated.playback import Shot

_ALONE_NS = 1_000_000_000
"""From the end to the beginning where a single picture tells no rhythm."""


class RecordingSource:
    """Plays one sensor's part of a recording: its pictures, the times between them, its frame ids.

    All files of the recording are played. Frames that the recording lacks are missing in the ids
    again, as the live camera's were. One picture is in memory at a time.
    """

    def __init__(
        self,
        path: Path,
        sensor: str | None = None,
        *,
        once: bool = False,
        rate_hz: float | None = None,
    ) -> None:
        """Open the recording.

        Parameters
        ----------
        path
            Its first file.
        sensor
            Whose pictures to play; needed where it holds those of several.
        once
            End after the last picture. It begins again otherwise, after as long as the longest
            pause between two pictures.
        rate_hz
            Pictures a second, evenly, instead of the times of the recording.

        Raises
        ------
        InputUnusable
            If there is no such file, or no picture of that sensor in it.
        RecordingUnreadable
            If a file is not a whole recording.
        """
        if not (rate_hz is None or rate_hz > 0.0):
            raise ValueError(f"rate_hz must be positive, got {rate_hz}")
        self._paths = parts_of(path)
        self.sensor = _sensor_of(self._paths, sensor)
        self._once = once
        self._step_ns = None if rate_hz is None else 1e9 / rate_hz
        self.height, self.width = next(self._recorded()).picture.shape
        self.rewind()

    def rewind(self) -> None:
        self._shots = self._play()
        self._upcoming = next(self._shots, None)

    def upcoming(self) -> Shot | None:
        return self._upcoming

    def take(self) -> None:
        self._upcoming = next(self._shots, None)

    def frame(self, index: int, exposure_us: float) -> Picture:
        """Return the next picture whatever its time; see `FrameSource.frame`."""
        if self._upcoming is None:
            self.rewind()
        shot = self._upcoming
        if shot is None:
            raise InputUnusable(f"{self._paths[0]}: no picture of {self.sensor} left in it")
        self.take()
        return shot.picture

    def _recorded(self) -> Iterator[RecordedFrame]:
        for path in self._paths:
            yield from frames(path, self.sensor)

    def _play(self) -> Iterator[Shot]:
        """Yield the shots, round after round."""
        count, elapsed_ns, block_id = 0, 0, 0
        while True:
            longest_ns, before = 0, None
            for now in self._recorded():
                if before is not None:
                    # A clock that was set back in between does not turn the order round.
                    pause_ns = max(0, now.camera_time_ns - before.camera_time_ns)
                    longest_ns = max(longest_ns, pause_ns)
                    elapsed_ns += pause_ns
                block_id = _next_id(block_id, before, now)
                even_ns = None if self._step_ns is None else round(count * self._step_ns)
                yield Shot(elapsed_ns if even_ns is None else even_ns, block_id, now.picture)
                count, before = count + 1, now
            if self._once or before is None:
                return
            elapsed_ns += longest_ns or _ALONE_NS


def _next_id(last_sent: int, before: RecordedFrame | None, now: RecordedFrame) -> int:
    """Return the block id of a frame: its own, or after as many as were missing before it."""
    if last_sent == 0:
        return (now.frame_id - 1) % LAST_BLOCK_ID + 1  # those of some cameras have 64 bits
    # None where a camera that was opened again counts from 1: nothing is known to be missing.
    missing = 0 if before is None else ids_skipped(before.frame_id, now.frame_id) or 0
    return id_after(last_sent, missing + 1)


def _sensor_of(paths: Sequence[Path], wanted: str | None) -> str:
    """Return the sensor whose pictures are to be played."""
    held = {one.sensor for path in paths for one in info(path).sensors if one.frames}
    if wanted in held:
        return wanted
    listed = ", ".join(sorted(held)) or "none"
    if wanted is not None or not held:
        of_sensor = f" of sensor {wanted!r}" if wanted else ""
        raise InputUnusable(f"{paths[0]}: no pictures{of_sensor} in it; it has those of: {listed}")
    if len(held) > 1:
        raise InputUnusable(
            f"{paths[0]}: pictures of several sensors in it ({listed}); say by --sensor whose"
        )
    return next(iter(held))
