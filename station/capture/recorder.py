"""The recorder: a process that writes what lies in the ring into a recording.

It is told what to do, and answers each order when it is done: an answer to a frame means that the
frame is in the file.  When the teller is gone it has written what it was still told; it says in the
file why that ends, and finishes it.
"""

import json
import signal
import sys
import time
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from station.capture.ring import Ring
from station.errors import RecordingError, StationError
from station.recording import CameraNumbers, Event, EventKind, RotatingWriter, Rotation

CALIBRATION = "calibration.json"


class Recorder:
    """Obeys the capture process at the other end of `link`."""

    def __init__(self, link: Connection, ring: Ring) -> None:
        self._link = link
        self._ring = ring
        self._writer: RotatingWriter | None = None
        self._failure: StationError | None = None

    def run(self) -> None:
        """Obey until the capture process closes the link or dies."""
        try:
            while True:
                order = json.loads(self._link.recv_bytes())
                self._link.send_bytes(json.dumps(self._answer(order)).encode())
        except (EOFError, ConnectionError):
            self._finish_alone()

    def _answer(self, order: dict[str, Any]) -> dict[str, Any]:
        try:
            return self._do(order)
        except StationError as error:
            self._failure = error
            return {"failed": type(error).__name__, "message": str(error)}

    def _do(self, order: dict[str, Any]) -> dict[str, Any]:
        match order["do"]:
            case "open":
                return {"opened": self._open(order)}
            case "frame":
                self._ready().write_frame(
                    order["frame_id"],
                    order["camera_time_ns"],
                    order["host_time_ns"],
                    self._ring.picture(order["slot"], order["width"] * order["height"]),
                    order["width"],
                    order["height"],
                )
                return {"written": True}
            case "event":
                self._ready().write_event(Event.from_json(order["event"]))
                return {"written": True}
            case "finish":
                return self._finish(order["accounting"])
            case "discard":
                if self._writer is not None:
                    self._writer.discard()
                    self._writer = None
                return {"discarded": True}
            case other:
                raise RecordingError(f"the recorder does not know the order {other!r}")

    def _ready(self) -> RotatingWriter:
        if self._failure is not None:
            raise self._failure
        if self._writer is None:
            raise RecordingError("no recording is open; open one first")
        return self._writer

    def _open(self, order: dict[str, Any]) -> int:
        """Begin a recording, or go on with one; return how many entries it holds."""
        self._failure = self._writer = None
        attachments = {name: bytes.fromhex(text) for name, text in order["attachments"].items()}
        document = attachments.get(CALIBRATION)
        self._writer = RotatingWriter(
            Path(order["path"]),
            order["sensor"],
            rotation=Rotation(**order["rotation"]),
            metadata=order["metadata"],
            attachments=attachments,
            camera=None if document is None else partial(CameraNumbers.of_calibration, document),
            reserve_bytes=order["reserve_bytes"],
            resume=order["resume"],
            files_before=order["files_before"],
        )
        return self._writer.entries_found

    def _finish(self, accounting: dict[str, str]) -> dict[str, Any]:
        """Finish the recording, unless a full disk has; return what it holds, and where."""
        if self._writer is None:
            raise RecordingError("no recording is open; open one first")
        summary = self._writer.finish(accounting if self._failure is None else None)
        self._writer = None
        return {"finished": summary.frames, "paths": [str(path) for path in summary.paths]}

    def _finish_alone(self) -> None:
        if self._writer is None:
            return
        if self._failure is None:
            event = Event(
                EventKind.CAPTURE_LOST, time.time_ns(), "the capture process died; frames may miss"
            )
            self._writer.write_event(event)
        self._writer.finish()


def main(link_descriptor: int, ring_descriptor: int, picture_bytes: int) -> None:
    """Be the recorder's process.

    Ctrl-C and a service manager's TERM reach every process of a group; the recorder ends when the
    capture process does, and not before it has finished its file.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    ring = Ring(ring_descriptor, picture_bytes)
    Recorder(Connection(link_descriptor), ring).run()


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:4]))
