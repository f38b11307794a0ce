"""Keeping a camera open: found lost, dropped, opened again."""

import contextlib
import time
from dataclasses import dataclass

import structlog

from station.capture.camera import Camera
from station.capture.link import RecorderLink
from station.capture.ring import Ring
from station.errors import CameraError, CameraRefused
from station.recording import EventKind
from station.settings import SensorSettings

_CHECK_INTERVAL_S = 1.0
_SILENT_CHECK_INTERVAL_S = 0.3
"""With 0.6 s until a silent camera is believed to be so, it is found lost within a second."""
_SENDING_S = 0.25
_RETRY_INTERVAL_S = 1.0
_FIRST_TRY_S = 0.3
_FEEL_INTERVAL_S = 10.0
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Trouble:
    """Why a camera that was open cannot be used."""

    kind: EventKind
    problem: str


class CameraKeeper:
    """The camera of a sensor, the ring for its frames, and the ring's recorder."""

    def __init__(self, settings: SensorSettings) -> None:
        self.camera: Camera | None = None
        self.problem: str | None = "not opened yet"
        """Why there is no camera."""
        self.description: dict[str, str] = {}
        """What the camera is and how it is set, as of its last opening."""
        self._settings = settings
        self._ring: Ring | None = None
        self._link: RecorderLink | None = None
        # Whoever starts the process for one recording arms it at once, and that opens the camera.
        self._next_s = time.monotonic() + _FIRST_TRY_S
        self._checked_s = self._feel_s = 0.0
        self.temperature_c: float | None = None
        """Of the camera, as it was asked last."""

    def ensure_open(self) -> tuple[Camera, Ring, RecorderLink]:
        """Return the camera with what belongs to it, opening it where it is not.

        Raises
        ------
        CameraUnreachable, CameraRefused
            If it cannot be opened.
        """
        if self.camera is None:
            try:
                camera = Camera(self._settings)
                self.description = camera.description()
            except CameraError as error:
                self._note(str(error))
                raise
            finally:
                self._next_s = time.monotonic() + _RETRY_INTERVAL_S
            self.camera = camera
            self._note(None)
        ring, link = self._ring_for(self.camera)
        return self.camera, ring, link

    def is_check_due(self, heard_s: float) -> bool:
        """Whether to look after the camera, from which the last frame came at `heard_s`."""
        if self.camera is None:
            return False
        now = time.monotonic()
        sending = now - heard_s < _SENDING_S
        interval_s = _CHECK_INTERVAL_S if sending else _SILENT_CHECK_INTERVAL_S
        return now >= self._checked_s + interval_s

    def trouble(self, silent_s: float, silence_allowed_s: float) -> Trouble | None:
        """Ask the camera, which takes a millisecond where it answers; return what is wrong.

        Parameters
        ----------
        silent_s
            Time since its last frame.
        silence_allowed_s
            How long a camera that is well may send nothing.
        """
        if self.camera is None:
            return None
        self._checked_s = time.monotonic()
        address = self._settings.address
        # First whether it is there: an order to a silent camera takes 2.5 s.
        if not self.camera.answers():
            return Trouble(
                EventKind.CAMERA_LOST, "the camera stopped answering; check its power and cable"
            )
        if not self.camera.obeys():
            return Trouble(
                EventKind.CAMERA_TAKEN,
                f"another program took control of camera {address}; end that program",
            )
        if silent_s > silence_allowed_s:
            return Trouble(
                EventKind.CAMERA_LOST, "the camera answers but sends no frames; it is opened again"
            )
        return None

    def look_after_recorder(self) -> None:
        """Have a recorder that died between two recordings followed by another at once.

        A train does not wait for one to start.
        """
        if self._link is not None and not self._link.is_recording:
            self._link.ensure_alive()

    def feel(self) -> None:
        """Ask now and then how warm the camera is; only while it sends nothing."""
        if self.camera is None or time.monotonic() < self._feel_s:
            return
        self._feel_s = time.monotonic() + _FEEL_INTERVAL_S
        # One that does not answer is found lost by what looks for that.
        with contextlib.suppress(CameraError):
            self.temperature_c = self.camera.temperature_c()

    def is_due(self) -> bool:
        """Whether to try again to open the camera."""
        return self.camera is None and time.monotonic() >= self._next_s

    def drop(self, problem: str) -> None:
        """Let go of a camera that is lost."""
        if self.camera is not None:
            self.camera.close(lost=True)
            # Those who ask for the state hear of it before the next try makes them wait.
            self._next_s = time.monotonic() + _FIRST_TRY_S
        self.camera = self.temperature_c = None
        self._note(problem)

    def _note(self, problem: str | None) -> None:
        """Keep why there is no camera; what is tried every second is logged when it changes."""
        if problem != self.problem:
            if problem is None:
                _log.info("camera open", address=self._settings.address)
            else:
                _log.warning("camera not there", address=self._settings.address, why=problem)
        self.problem = problem

    def close(self) -> None:
        """Let go of everything; a recorder with an open file finishes it."""
        if self.camera is not None:
            self.camera.close(lost=False)
            self.camera = None
        if self._link is not None:
            self._link.close()
        self._ring = self._link = None

    def _ring_for(self, camera: Camera) -> tuple[Ring, RecorderLink]:
        """Return ring and recorder; new ones where the camera's pictures have another size."""
        if self._ring is not None and self._ring.picture_bytes != camera.payload_bytes:
            if self._link is not None and self._link.is_recording:
                raise CameraRefused(
                    f"camera {self._settings.address} came back with pictures of "
                    f"{camera.payload_bytes} bytes, {self._ring.picture_bytes} are being recorded; "
                    "finish the recording first"
                )
            if self._link is not None:
                self._link.close()
            self._ring = self._link = None
        if self._ring is None:
            self._ring = Ring.create(self._settings.ring_slots, camera.payload_bytes)
        if self._link is None:
            self._link = RecorderLink(self._ring)
        return self._ring, self._link
