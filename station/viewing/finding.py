"""Finding the frame that is wanted: in a recording, finished or growing, or in shared memory."""

import mmap
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib import Picture
from station.errors import NotFound
from station.recording import FrameTable, GrowingRecording, RecordedFrame
from station.viewing.orders import SeenFrame, SharedPicture, ViewOrder
from station.viewing.tables import Tables

_MOST_GROWING = 8
"""Recordings that are kept open; a station has fewer sensors in use."""
_PACE_S = 0.15
"""Whoever asks for the newest frame so soon after another gets the same: who looks does not see the
difference, and many who look cost no more than one."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A frame, and how to get at its picture, shape (H, W), 8 bit."""

    frame: SeenFrame
    picture: Callable[[], Picture]
    table: FrameTable | None = None
    """All frames of the recording; None of one that grows, and of a picture that is in none."""


class Finder:
    """Finds frames; of recordings that grow it remembers how far it has read."""

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._clock_s = clock_s
        self._growing: OrderedDict[Path, _Newest] = OrderedDict()
        self._tables = Tables()

    def find(self, order: ViewOrder) -> Found:
        """Return the frame that an order wants.

        Raises
        ------
        NotFound
            If the recording has no such frame, or none yet.
        InputUnusable, RecordingUnreadable
            If it is not there, or damaged.
        """
        if order.shared is not None:
            return _shared(order.shared)
        if order.recording is None:
            raise ValueError("an order without recording and picture")
        if order.growing:
            return self._newest_of(order.recording)
        self._forget(order.recording)
        return _recorded(self._tables.of(order.recording), order.number)

    def _newest_of(self, path: Path) -> Found:
        newest = self._growing.get(path)
        if newest is None:
            newest = self._growing[path] = _Newest(path, self._clock_s)
        self._growing.move_to_end(path)
        if len(self._growing) > _MOST_GROWING:
            self._growing.popitem(last=False)[1].close()
        try:
            return newest.found()
        except Exception:  # whatever it was goes on to who asked
            self._forget(path)  # the next who asks begins anew
            raise

    def _forget(self, path: Path) -> None:
        newest = self._growing.pop(path, None)
        if newest is not None:
            newest.close()


class _Newest:
    """The newest frame of a recording that grows."""

    def __init__(self, path: Path, clock_s: Callable[[], float]) -> None:
        self._recording = GrowingRecording(path)
        self._clock_s = clock_s
        self._looked_s = -_PACE_S
        self._found: Found | None = None

    def close(self) -> None:
        self._recording.close()

    def found(self) -> Found:
        now_s = self._clock_s()
        if now_s - self._looked_s >= _PACE_S or self._found is None:
            self._looked_s = now_s
            newest = self._recording.read_newest()
            if newest is not None:
                place, frame = newest
                self._found = _found_in(frame, place.frames + 1)
        if self._found is None:
            raise NotFound("the recording has no frame yet")
        return self._found


def _found_in(frame: RecordedFrame, number: int) -> Found:
    seen = SeenFrame(number, frame.frame_id, frame.camera_time_ns, frame.host_time_ns)
    return Found(seen, lambda: frame.picture)


def _recorded(table: FrameTable, number: int | None) -> Found:
    if len(table) == 0:
        raise NotFound("the recording has no frame on the disk")
    listed, picture = table.frame(len(table) if number is None else number)
    seen = SeenFrame(listed.number, listed.frame_id, listed.camera_time_ns, listed.host_time_ns)
    return Found(seen, lambda: picture, table)


def _shared(shared: SharedPicture) -> Found:
    def picture() -> Picture:
        size = shared.width * shared.height
        with mmap.mmap(shared.descriptor, size, prot=mmap.PROT_READ) as memory:
            return np.frombuffer(memory.read(size), np.uint8).reshape(shared.height, shared.width)

    return Found(SeenFrame(None, None, shared.received_ns, shared.received_ns), picture)
