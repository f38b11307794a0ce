"""A camera that shows a recording again."""

from collections.abc import Iterator
from pathlib import Path

from calib import Picture
from station.errors import InputUnusable
from station.recording import RecordedFrame, frames


class RecordingSource:
    """Serves the pictures of one sensor of a recording in their order, over and over.

    One picture is in memory at a time. Their spacing in time is the camera's, not the recording's.
    """

    def __init__(self, path: Path, sensor: str | None = None) -> None:
        """Open the recording; without `sensor`, the sensor of its first picture is shown.

        Raises
        ------
        InputUnusable
            If there is no such file, or no picture of that sensor in it.
        RecordingUnreadable
            If it is not a whole recording.
        """
        self._path = path
        first = next(frames(path, sensor), None)
        if first is None:
            of_sensor = f" of sensor {sensor!r}" if sensor else ""
            raise InputUnusable(
                f"{path}: no pictures{of_sensor} in it; `station recording info` tells what is"
            )
        self.sensor = first.sensor
        self.height, self.width = first.picture.shape
        self._frames: Iterator[RecordedFrame] = iter(())

    def frame(self, index: int, exposure_us: float) -> Picture:
        recorded = next(self._frames, None)
        if recorded is None:
            self._frames = frames(self._path, self.sensor)
            recorded = next(self._frames)
        return recorded.picture
