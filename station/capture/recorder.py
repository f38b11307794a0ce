"""The recorder: a process that writes what lies in the ring into a recording.

It is told what to do, and answers each order when it is done: an answer to a frame means that the
frame is in the file.  When the teller is gone it has written what it was still told; it says in the
file why that ends, and finishes it.
"""

import json
import signal
import sys
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from station.capture.ring import Ring
from station.errors import RecordingError, StationError
from station.recording import Event, EventKind, RecordingWriter

CALIBRATION = "calibration.json"


class Recorder:
    """Obeys the capture process at the other end of `link`."""

    def __init__(self, link: Connection, ring: Ring) -> None:
        self._link = link
        self._ring = ring
        self._writer: RecordingWriter | None = None
        self._sensor = ""
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
                    self._sensor,
                    order["frame_id"],
                    order["camera_time_ns"],
                    order["host_time_ns"],
                    self._ring.picture(order["slot"], order["width"] * order["height"]),
                    order["width"],
                    order["height"],
                )
                return {"written": True}
            case "event":
                self._ready().write_event(self._sensor, Event.from_json(order["event"]))
                return {"written": True}
            case "finish":
                return {"finished": self._finish(order["accounting"])}
            case "discard":
                if self._writer is not None:
                    self._writer.discard()
                    self._writer = None
                return {"discarded": True}
            case other:
                raise RecordingError(f"the recorder does not know the order {other!r}")

    def _ready(self) -> RecordingWriter:
        if self._failure is not None:
            raise self._failure
        if self._writer is None:
            raise RecordingError("no recording is open; open one first")
        return self._writer

    def _open(self, order: dict[str, Any]) -> int:
        """Begin a recording, or go on with one; return how many entries it holds."""
        self._failure, self._writer, self._sensor = None, None, order["sensor"]
        attachments = {name: bytes.fromhex(text) for name, text in order["attachments"].items()}
        self._writer = RecordingWriter(
            Path(order["path"]),
            metadata=order["metadata"],
            attachments=attachments,
            resume=order["resume"],
        )
        if CALIBRATION in attachments and not order["resume"]:
            self._write_calibration(attachments[CALIBRATION])
        return self._writer.frames_written(self._sensor) + self._writer.events_written(self._sensor)

    def _write_calibration(self, document: bytes) -> None:
        from station.documents import CalibrationDocument  # noqa: PLC0415  costs 0.2 s, seldom used

        camera = CalibrationDocument.model_validate_json(document).camera.model()
        self._ready().write_calibration(self._sensor, camera)

    def _finish(self, accounting: dict[str, str]) -> int:
        """Finish the recording, unless a full disk has; return how many frames it holds."""
        if self._writer is None:
            raise RecordingError("no recording is open; open one first")
        if self._failure is None:
            self._writer.write_metadata("accounting", accounting)
        summary = self._writer.finish()
        self._writer = None
        return summary.frames.get(self._sensor, 0)

    def _finish_alone(self) -> None:
        if self._writer is None:
            return
        if self._failure is None:
            event = Event(
                EventKind.CAPTURE_LOST, time.time_ns(), "the capture process died; frames may miss"
            )
            self._writer.write_event(self._sensor, event)
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
