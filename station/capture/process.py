"""The capture process: it keeps one camera open and records when it is told to.

One thread does everything: it asks the driver for frames, the recorder for answers and the socket
for orders, none for long.  Nothing has to be locked, and no work of one holds up another's.
"""

import os
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from station.capture.camera import Camera
from station.capture.control import Caller, ControlServer
from station.capture.link import RecorderLink
from station.capture.plan import CaptureReport, RecordingPlan, Trigger
from station.capture.ring import Ring
from station.capture.session import CaptureSession
from station.capture.status import ALLOWED, CaptureState, CaptureStatus
from station.errors import CameraError, CameraLost, StateConflict, StationError
from station.settings import SensorSettings

_IDLE_WAIT_S = 0.1
_CHECK_INTERVAL_S = 1.0
_REOPEN_INTERVAL_S = 0.5
_TRIGGER_TIMEOUT_S = 3.0


@dataclass(slots=True)
class _Waiting:
    """An order that is answered later."""

    caller: Caller
    deadline_s: float
    expected: int | None = None


class CaptureProcess:
    """One sensor's camera, ring, recorder and socket."""

    def __init__(self, settings: SensorSettings, socket_path: Path) -> None:
        self._settings = settings
        self._control = ControlServer(socket_path)
        self._state = CaptureState.UNAVAILABLE
        self._problem: str | None = "not opened yet"
        self._camera: Camera | None = None
        self._ring: Ring | None = None
        self._link: RecorderLink | None = None
        self._session: CaptureSession | None = None
        self._report: CaptureReport | None = None
        self._finishing: _Waiting | None = None
        self._triggering: _Waiting | None = None
        self._checked_s = self._tried_s = -1e9
        self._parent = os.getppid()
        self._ending = False

    def end(self) -> None:
        """End at the next opportunity, with the recording finished."""
        self._ending = True

    def run(self) -> None:
        """Serve until told to end, or until the process that started this one is gone."""
        try:
            while not self._ending and os.getppid() == self._parent:
                self._turn()
        finally:
            self._shut_down()

    def _turn(self) -> None:
        acquiring = self._state is CaptureState.RECORDING
        for caller, order in self._control.orders(0.0 if acquiring else _IDLE_WAIT_S):
            self._obey(caller, order)
        if self._session is not None and self._report is None:
            self._session.intake.step()
            self._advance(self._session)
        self._watch_camera()
