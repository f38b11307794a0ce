"""Keeping a camera open: found lost, dropped, opened again."""

import time

from station.capture.camera import Camera
from station.capture.link import RecorderLink
from station.capture.ring import Ring
from station.errors import CameraError, CameraRefused
from station.settings import SensorSettings

_CHECK_INTERVAL_S = 1.0
_RETRY_INTERVAL_S = 1.0
_FIRST_TRY_S = 0.3


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
                self.problem = str(error)
                raise
            finally:
                self._next_s = time.monotonic() + _RETRY_INTERVAL_S
            self.camera, self.problem = camera, None
        ring, link = self._ring_for(self.camera)
        return self.camera, ring, link

    def found_lost(self, heard_s: float) -> bool:
        """Whether the camera, last heard of at `heard_s`, has been lost since; asks now and then.

        A camera that sends frames is there.  One that does not is asked, which takes a
        millisecond where it answers.
        """
        now = time.monotonic()
        if self.camera is None or now < self._next_s:
            return False
        self._next_s = now + _CHECK_INTERVAL_S
        sending = now - heard_s < _CHECK_INTERVAL_S
        return not (self.camera.in_control() if sending else self.camera.answers())

    def is_due(self) -> bool:
        """Whether to try again to open the camera."""
        return self.camera is None and time.monotonic() >= self._next_s

    def drop(self, problem: str) -> None:
        """Let go of a camera that is lost."""
        if self.camera is not None:
            self.camera.close(lost=True)
        self.camera, self.problem = None, problem

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
