"""The capture process: it obeys the orders that come over its socket, until its parent is gone.

One thread does everything: it asks the driver for frames, the recorder for answers and the socket
for orders, none of them for long.  Nothing has to be locked, and nothing holds up the frames.
"""

import os
import signal
from pathlib import Path
from typing import Any

import structlog

from station.capture.control import Caller, ControlServer, refusal
from station.capture.plan import RecordingPlan
from station.capture.sensor_capture import SensorCapture
from station.capture.status import CaptureState
from station.errors import InputUnusable, StateConflict, StationError
from station.settings import SensorSettings

_IDLE_WAIT_S = 0.1
_REFUSABLE = (KeyError, TypeError, ValueError)
"""What an order that is not well formed raises."""

_ALLOWED: dict[str, frozenset[CaptureState]] = {
    "status": frozenset(CaptureState),
    "arm": frozenset({CaptureState.UNAVAILABLE, CaptureState.IDLE, CaptureState.RECORDED}),
    "look": frozenset({CaptureState.IDLE, CaptureState.RECORDING}),
    "trigger": frozenset({CaptureState.RECORDING}),
    "finish": frozenset({CaptureState.RECORDING, CaptureState.BLIND, CaptureState.RECORDED}),
    "shutdown": frozenset(CaptureState),
}
"""In which states an order is obeyed."""


class CaptureProcess:
    """One sensor's camera and recordings, behind a socket."""

    def __init__(self, settings: SensorSettings, socket_path: Path, parent_pid: int) -> None:
        self._sensor = settings.id
        self._control = ControlServer(socket_path)
        self._capture = SensorCapture(settings)
        self._parent_pid = parent_pid
        self._ending = False

    def end(self) -> None:
        """End at the next opportunity, with the recording finished."""
        self._ending = True

    def run(self) -> None:
        """Serve until told to end, or until the parent process is gone."""
        try:
            while not self._ending and os.getppid() == self._parent_pid:
                self._turn()
        finally:
            self._capture.close()
            self._control.close()

    def _turn(self) -> None:
        recording = self._capture.state is CaptureState.RECORDING
        for caller, order in self._control.orders(0.0 if recording else _IDLE_WAIT_S):
            self._obey(caller, order)
        self._capture.step()

    def _obey(self, caller: Caller, order: dict[str, Any]) -> None:
        try:
            self._carry_out(order, caller)
        except StationError as error:
            caller.answer(refusal(error))
        except _REFUSABLE as error:
            caller.answer(refusal(InputUnusable(f"not a usable order: {error}")))

    def _carry_out(self, order: dict[str, Any], caller: Caller) -> None:
        """Do as ordered and answer; an answer that must wait for frames comes later."""
        name, state = order["do"], self._capture.state
        if state not in _ALLOWED[name]:
            raise StateConflict(
                f"sensor {self._sensor} is {state}; `{name}` needs it to be "
                f"{' or '.join(sorted(_ALLOWED[name]))}",
                state=str(state),
            )
        match name:
            case "status":
                caller.answer({"status": self._capture.status().to_json()})
            case "arm":
                self._capture.arm(RecordingPlan.from_json(order["plan"]), caller.answer)
            case "look":
                with self._capture.look() as look:
                    caller.answer({"look": look.to_json()}, look.descriptor)
            case "trigger":
                self._capture.trigger(caller.answer)
            case "finish":
                timeout_s = float(order["timeout_s"])
                self._capture.finish(order["expected"], timeout_s, caller.answer)
            case "shutdown":
                self._ending = True
                caller.answer({})


def run_capture(settings: SensorSettings, socket_path: Path, parent_pid: int) -> None:
    """Be the capture process of one sensor, until told to end by socket or SIGTERM.

    Ctrl-C at a terminal reaches every process of its group; who started this one decides.

    Parameters
    ----------
    parent_pid
        The process to end with.  Asked for here it would be another's, had the parent died already.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    structlog.contextvars.bind_contextvars(sensor=settings.id)
    process = CaptureProcess(settings, socket_path, parent_pid)
    signal.signal(signal.SIGTERM, lambda *_: process.end())
    process.run()
