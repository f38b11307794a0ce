"""Where every frame of a finished recording lies and when it came: read once, asked often.

Who scrubs through a recording asks for one frame after the other.  Finding each anew would read the
index of its files each time, a quarter of a second where it has 32,000 frames.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np
from mcap.records import ChunkIndex
from numpy.typing import NDArray

from station.errors import NotFound
from station.recording.browsing import (
    Entry,
    ListedFrame,
    as_listed,
    chunks_with_frames,
    headers_of,
    message_at,
)
from station.recording.chunks import StoredMessage
from station.recording.opening import Recording, open_file, open_recording
from station.recording.reader import picture_of

if TYPE_CHECKING:  # importing `calib` would make a new recorder late by half a second
    from calib import Picture

_CLOSED = -1
_ROW = np.dtype([
    ("file", np.int32),
    ("channel", np.uint16),
    ("frame_id", np.int64),
    ("camera_time_ns", np.int64),
    ("host_time_ns", np.int64),
    ("chunk_start", np.int64),
    ("chunk_length", np.int64),
    ("chunk_content", np.int64),  # bytes of its records
    ("offset", np.int64),  # in the records of the chunk
])
_Row = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class FrameTable:
    """The frames of a recording in the order they were written; a row takes 60 bytes."""

    files: tuple[Recording, ...]
    """Closed, and without their chunks."""
    rows: NDArray[np.void]
    """Shape (N,), fields of `_ROW`; read-only."""

    @classmethod
    def of(cls, files: Sequence[Path]) -> Self:
        """Read the table of a recording from all of its files, in order.

        Raises
        ------
        InputUnusable
            If a file is not there.
        RecordingUnreadable
            If one is no whole recording, or damaged around a frame.
        """
        closed: list[Recording] = []
        found = [np.empty(0, dtype=_ROW)]
        for number, path in enumerate(files):
            with open_recording(path) as recording:
                found.append(_rows(recording, number))
                closed.append(replace(recording, descriptor=_CLOSED, chunks=()))
        rows = np.concatenate(found)
        rows.setflags(write=False)
        return cls(tuple(closed), rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def frame_ids(self) -> NDArray[np.int64]:
        """As the camera numbers them, shape (N,)."""
        return np.asarray(self.rows["frame_id"], np.int64)

    @property
    def camera_times_ns(self) -> NDArray[np.int64]:
        """When the frames were exposed, UTC, shape (N,)."""
        return np.asarray(self.rows["camera_time_ns"], np.int64)

    @property
    def host_times_ns(self) -> NDArray[np.int64]:
        """When they were received, by the host's clock, UTC, shape (N,)."""
        return np.asarray(self.rows["host_time_ns"], np.int64)

    def numbers_of(self, frame_ids: Iterable[int]) -> dict[int, int]:
        """Return the numbers, from 1, of frames by their ids; those not in it are left out."""
        order = np.argsort(self.frame_ids, kind="stable")
        ids = self.frame_ids[order]
        wanted = np.array(sorted(set(frame_ids)), dtype=np.int64)
        places = np.searchsorted(ids, wanted)
        return {
            int(frame_id): int(order[place]) + 1
            for frame_id, place in zip(wanted, places, strict=True)
            if place < len(ids) and ids[place] == frame_id
        }

    def frame(self, number: int) -> tuple[ListedFrame, "Picture"]:
        """Return the frame of that number, from 1, with its picture; its checksum is held.

        Raises
        ------
        NotFound
            If there is no such frame.
        InputUnusable
            If its file has gone meanwhile.
        RecordingUnreadable
            If it is damaged, or its file is another one meanwhile.
        """
        if not (1 <= number <= len(self)):
            raise NotFound(f"the recording has {len(self)} frames; there is no frame {number}")
        row = self.rows[number - 1]
        closed = self.files[row["file"]]
        descriptor = open_file(closed.path)
        try:
            recording = replace(closed, descriptor=descriptor)
            message = message_at(recording, _chunk(row), (int(row["offset"]), int(row["channel"])))
            return as_listed(recording, number, message), picture_of(recording, message)
        finally:
            os.close(descriptor)


def _rows(recording: Recording, file: int) -> NDArray[np.void]:
    try:
        return np.array(list(_found(recording, file)), dtype=_ROW)
    except OverflowError as error:  # a time that no clock shows
        raise recording.damaged("in the header of a frame", error) from error


def _found(recording: Recording, file: int) -> Iterator[_Row]:
    for _, chunk, entries in chunks_with_frames(recording, 0):
        place = chunk.chunk_start_offset, chunk.chunk_length, chunk.uncompressed_size
        for entry, header in zip(entries, headers_of(recording, chunk, entries), strict=True):
            yield _row(file, header, place, entry)


def _row(file: int, header: StoredMessage, place: tuple[int, int, int], entry: Entry) -> _Row:
    times = header.publish_time_ns, header.log_time_ns
    return (file, header.channel, header.sequence, *times, *place, entry[0])


def _chunk(row: np.void) -> ChunkIndex:
    """Return as much of a chunk's index as finding a message in it takes."""
    return ChunkIndex(
        chunk_length=int(row["chunk_length"]),
        chunk_start_offset=int(row["chunk_start"]),
        compression="",
        compressed_size=0,
        message_end_time=0,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=0,
        uncompressed_size=int(row["chunk_content"]),
    )
