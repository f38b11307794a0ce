"""The capture process's side of its recorder: orders, answers, and another one when it dies."""

import json
import socket
import subprocess
import sys
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from station import errors
from station.capture.plan import RecordingPlan
from station.capture.ring import Ring
from station.errors import RecordingError, StationError
from station.recording import Event, active_path, info, left_behind, part_path

_START_TIMEOUT_S = 20.0
_FINISH_TIMEOUT_S = 60.0


@dataclass(frozen=True, slots=True)
class FrameEntry:
    """A frame that waits in the ring to be written."""

    slot: int
    frame_id: int
    camera_time_ns: int
    host_time_ns: int
    width: int
    height: int

    def order(self) -> dict[str, Any]:
        """Return the order to write it."""
        names = ("slot", "frame_id", "camera_time_ns", "host_time_ns", "width", "height")
        return {"do": "frame", **{name: getattr(self, name) for name in names}}


Entry = FrameEntry | Event


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of an entry: it is in the file, or why not."""

    entry: Entry
    failure: StationError | None = None


class RecorderDied(RecordingError):
    """The recorder's process is gone; where another can go on, this stays within the process."""

    def __init__(self) -> None:
        super().__init__("the recorder's process died; record again, and see the system's log")


class RecorderLink:
    """A recorder process and the entries it has not yet confirmed.

    The recorder writes in the order it is told, and what it wrote survives it.  So when it dies,
    the number of entries in the file tells which of those on the way are still to be written; they
    lie in the ring, and another recorder writes them.

    Whatever gives it an order or hears its answers raises RecorderDied where it is gone; what waits
    for an answer raises RecordingError where none comes in time, or the error that it answers with.
    """

    def __init__(self, ring: Ring) -> None:
        self._ring = ring
        self._pending: deque[Entry] = deque()
        self._confirmed = 0
        self._opening: dict[str, Any] = {}
        self._paths: tuple[Path, ...] = ()
        self._start()

    @property
    def pid(self) -> int:
        """Process id of the recorder."""
        return self._process.pid

    @property
    def pending(self) -> int:
        """Entries on their way to the file."""
        return len(self._pending)

    @property
    def is_recording(self) -> bool:
        """Whether a recording is open."""
        return bool(self._opening)

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files of the recording; those after the first are known once it is finished."""
        return self._paths

    def open(self, plan: RecordingPlan, metadata: Mapping[str, Mapping[str, str]]) -> None:
        """Begin a recording.

        Raises
        ------
        InputUnusable
            If its file exists, or the folder does not take it.
        """
        self._pending.clear()
        self._confirmed = 0
        self._opening = {
            "do": "open",
            "path": str(plan.path),
            "sensor": plan.sensor,
            "metadata": {name: dict(values) for name, values in metadata.items()},
            "attachments": {name: content.hex() for name, content in plan.attachments.items()},
            "rotation": asdict(plan.rotation),
            "reserve_bytes": plan.reserve_bytes,
            "files_before": 0 if plan.goes_on is None else plan.goes_on.files,
        }
        self._paths = (plan.path,)
        self.ensure_alive()
        try:
            self._begin()
        except StationError:
            self._opening = {}
            raise

    def _begin(self) -> None:
        try:
            self._ask({**self._opening, "resume": False}, _START_TIMEOUT_S)
        except RecorderDied:
            # Killed at this very moment; nothing is in the file yet that another could not write.
            self._close()
            self._start()
            first = part_path(self._paths[0], self._opening["files_before"] + 1)
            begun = active_path(first).exists()
            self._ask({**self._opening, "resume": begun}, _START_TIMEOUT_S)

    def ensure_alive(self) -> None:
        """Start another recorder where this one died with nothing to do.

        One that dies in the middle of a recording is followed by `restart`.
        """
        if self._process.poll() is not None:
            self._close()
            self._start()

    def discard(self) -> None:
        """Take back the recording just opened."""
        self._ask({"do": "discard"}, _START_TIMEOUT_S)
        self._opening = {}

    def put(self, entry: Entry) -> None:
        """Order an entry to be written."""
        self._pending.append(entry)
        self._order(entry)

    def outcomes(self, timeout_s: float = 0.0) -> Iterator[Outcome]:
        """Yield what has become of entries since the last call."""
        while self._pending and self._has_answer(timeout_s):
            answer = self._receive()
            entry = self._pending.popleft()
            if "written" in answer:
                self._confirmed += 1
                yield Outcome(entry)
            else:
                yield Outcome(entry, _error(answer))

    def restart(self) -> tuple[Outcome, ...]:
        """Start another recorder that goes on with the file.

        Returns
        -------
        outcomes
            Entries that were in the file, though the recorder died before it said so.
        """
        self._close()
        self._start()
        written = self._ask({**self._opening, "resume": True}, _START_TIMEOUT_S)["opened"]
        unsaid = max(0, written - self._confirmed)
        outcomes = tuple(Outcome(self._pending.popleft()) for _ in range(unsaid))
        self._confirmed += unsaid
        for entry in self._pending:
            self._order(entry)
        return outcomes

    def abandon(self) -> tuple[Entry, ...]:
        """Give up the entries on their way; return them."""
        given_up = tuple(self._pending)
        self._pending.clear()
        return given_up

    def finish(self, accounting: Mapping[str, str]) -> int:
        """Finish the recording, all entries being answered; return how many frames it holds."""
        answer = self._ask({"do": "finish", "accounting": dict(accounting)}, _FINISH_TIMEOUT_S)
        self._opening = {}
        self._paths = tuple(Path(path) for path in answer["paths"])
        return int(answer["finished"])

    def finished_unsaid(self) -> int | None:
        """Return how many frames a recorder finished that died before it said so.

        None where it had not come so far.
        """
        parts = [part for _, part in left_behind(self._paths[0])]
        if not parts or any(active_path(part).exists() for part in parts):
            return None
        self._opening = {}
        self._paths = tuple(parts)
        return sum(sensor.frames for part in parts for sensor in info(part).sensors)

    def kill(self) -> None:
        """End a recorder that is stuck; the next order finds it dead."""
        self._process.kill()

    def close(self) -> None:
        """End the recorder; an unfinished recording is finished by it."""
        self._close()

    def _start(self) -> None:
        ours, theirs = socket.socketpair()
        descriptors = (theirs.fileno(), self._ring.descriptor)
        arguments = [*map(str, descriptors), str(self._ring.picture_bytes)]
        command = [sys.executable, "-m", "station.capture.recorder", *arguments]
        self._process = subprocess.Popen(command, pass_fds=descriptors)  # noqa: S603  our own code
        theirs.close()
        self._link = Connection(ours.detach())

    def _close(self) -> None:
        self._link.close()
        try:
            self._process.wait(_FINISH_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()  # and not waited for: a disk that hangs may hold it

    def _order(self, entry: Entry) -> None:
        if isinstance(entry, FrameEntry):
            self._send(entry.order())
        else:
            self._send({"do": "event", "event": entry.to_json()})

    def _ask(self, order: dict[str, Any], timeout_s: float) -> dict[str, Any]:
        self._send(order)
        if not self._has_answer(timeout_s):
            raise RecordingError(
                f"the recorder did not answer within {timeout_s:.0f} s; is the disk stuck?"
            )
        answer = self._receive()
        if "failed" in answer:
            raise _error(answer)
        return answer

    def _send(self, order: dict[str, Any]) -> None:
        try:
            self._link.send_bytes(json.dumps(order).encode())
        except OSError as error:
            raise RecorderDied from error

    def _has_answer(self, timeout_s: float) -> bool:
        try:
            return self._link.poll(timeout_s)
        except OSError as error:
            raise RecorderDied from error

    def _receive(self) -> dict[str, Any]:
        try:
            return dict(json.loads(self._link.recv_bytes()))
        except (EOFError, OSError) as error:
            raise RecorderDied from error


def _error(answer: Mapping[str, str]) -> StationError:
    """Return the station's error that an answer names."""
    kind = getattr(errors, answer["failed"], RecordingError)
    error: StationError = kind(answer["message"])
    return error
