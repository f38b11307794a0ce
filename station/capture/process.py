"""The capture process: it keeps one camera open and records when it is told to.

One thread does everything: it asks the driver for frames, the recorder for answers and the socket
for orders, none of them for long.  Nothing has to be locked, and nothing holds up the frames.
"""

import math
import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from station.capture.camera import Camera
from station.capture.control import Caller, ControlServer
from station.capture.keeper import CameraKeeper
from station.capture.plan import CaptureReport, RecordingPlan, Trigger
from station.capture.session import CaptureSession
from station.capture.status import CaptureState, CaptureStatus
from station.errors import CameraError, InputUnusable, StateConflict, StationError
from station.settings import SensorSettings

_IDLE_WAIT_S = 0.1
_TRIGGER_TIMEOUT_S = 2.0
_COUNTED = ("recorded", "lost", "refused", "repeated", "resent_packets")
_REFUSABLE = (KeyError, TypeError, ValueError)
"""What an order that is not well formed raises."""

_ALLOWED: dict[str, frozenset[CaptureState]] = {
    "status": frozenset(CaptureState),
    "arm": frozenset({CaptureState.UNAVAILABLE, CaptureState.IDLE, CaptureState.RECORDED}),
    "trigger": frozenset({CaptureState.RECORDING}),
    "finish": frozenset({CaptureState.RECORDING, CaptureState.BLIND, CaptureState.RECORDED}),
    "shutdown": frozenset(CaptureState),
}
"""In which states an order is obeyed."""


@dataclass(frozen=True, slots=True)
class _Finishing:
    """A caller that waits for the report."""

    caller: Caller
    deadline_s: float
    expected: int | None


@dataclass(frozen=True, slots=True)
class _Triggering:
    """A caller that waits for the frame it triggered."""

    caller: Caller
    deadline_s: float
    recorded: int
    refused: int


class CaptureProcess:
    """One sensor's camera, recorder and socket."""

    def __init__(self, settings: SensorSettings, socket_path: Path) -> None:
        self._sensor = settings.id
        self._control = ControlServer(socket_path)
        self._keeper = CameraKeeper(settings)
        self._session: CaptureSession | None = None
        self._report: CaptureReport | None = None
        self._finishing: _Finishing | None = None
        self._triggering: _Triggering | None = None
        self._blank = CaptureStatus(CaptureState.IDLE, settings.id)
        self._totals = dict.fromkeys(_COUNTED, 0)
        self._parent = os.getppid()
        self._ending = False

    @property
    def state(self) -> CaptureState:
        """The present state; it follows from what there is."""
        if self._report is not None:
            return CaptureState.RECORDED
        has_camera = self._keeper.camera is not None
        if self._session is not None:
            return CaptureState.RECORDING if has_camera else CaptureState.BLIND
        return CaptureState.IDLE if has_camera else CaptureState.UNAVAILABLE

    def end(self) -> None:
        """End at the next opportunity, with the recording finished."""
        self._ending = True

    def run(self) -> None:
        """Serve until told to end, or until the process that started this one is gone."""
        try:
            while not self._ending and os.getppid() == self._parent:
                self._turn()
        finally:
            if self._session is not None:
                self._conclude(self._session, expected=None)
            self._keeper.close()
            self._control.close()

    def _turn(self) -> None:
        recording = self.state is CaptureState.RECORDING
        for caller, order in self._control.orders(0.0 if recording else _IDLE_WAIT_S):
            self._obey(caller, order)
        if self._session is not None:
            self._session.intake.step()
            self._answer_trigger(self._session)
            self._answer_finish(self._session)
        self._watch_camera()

    # -- orders ---------------------------------------------------------------------------------

    def _obey(self, caller: Caller, order: dict[str, Any]) -> None:
        try:
            answer = self._done(caller, order)
        except StationError as error:
            answer = {"error": type(error).__name__, "message": str(error)}
            answer["state"] = getattr(error, "state", None)
        except _REFUSABLE as error:
            answer = {"error": InputUnusable.__name__, "message": f"not a usable order: {error}"}
        if answer is not None:
            caller.answer(answer)

    def _done(self, caller: Caller, order: dict[str, Any]) -> dict[str, Any] | None:
        """Carry out an order; return its answer, or None where that comes later."""
        name = order["do"]
        if self.state not in _ALLOWED[name]:
            raise StateConflict(
                f"sensor {self._sensor} is {self.state}; `{name}` needs it to be "
                f"{' or '.join(sorted(_ALLOWED[name]))}",
                state=str(self.state),
            )
        match name:
            case "status":
                return {"status": self._status().to_json()}
            case "arm":
                self._arm(RecordingPlan.from_json(order["plan"]))
            case "trigger":
                self._trigger(caller)
                return None
            case "finish":
                return self._finish(caller, order["expected"], float(order["timeout_s"]))
            case "shutdown":
                self._ending = True
        return {}

    def _status(self) -> CaptureStatus:
        keeper = self._keeper
        base = CaptureStatus(self.state, self._sensor, keeper.problem, keeper.description)
        if keeper.camera is not None:
            warnings = tuple(text for _, text in keeper.camera.warnings)
            base = replace(base, warnings=warnings)
        if self._session is None:
            return replace(base, totals=self._totals)
        status = self._session.status(base)
        return replace(status, totals=_added(self._totals, status))

    def _drop_session(self) -> None:
        """Let go of a recording that is closed; what it counted stays in the totals."""
        if self._session is not None:
            self._totals = _added(self._totals, self._session.status(self._blank))
        self._session = self._report = None

    def _arm(self, plan: RecordingPlan) -> None:
        camera, ring, link = self._keeper.ensure_open()
        self._drop_session()
        self._session = CaptureSession(plan, camera, ring, link)

    def _trigger(self, caller: Caller) -> None:
        session, camera = self._session, self._keeper.camera
        if session is None or camera is None or session.plan.trigger is not Trigger.SOFTWARE:
            raise StateConflict("the recording's trigger is not `software`", state=str(self.state))
        if self._triggering is not None:
            raise StateConflict("a trigger is under way; wait for its frame", state=str(self.state))
        session.sequencer.begin()
        self._fire(session, camera, caller)

    def _fire(self, session: CaptureSession, camera: Camera, caller: Caller) -> None:
        """Take the next frame of the group; `_answer_trigger` goes on when it has come."""
        account = session.intake.account
        recorded, refused = account.recorded, account.refused
        session.sequencer.fire(camera)
        deadline_s = time.monotonic() + _TRIGGER_TIMEOUT_S + camera.exposure_us * 1e-6
        self._triggering = _Triggering(caller, deadline_s, recorded, refused)

    def _finish(
        self, caller: Caller, expected: int | None, timeout_s: float
    ) -> dict[str, Any] | None:
        if self._report is not None:
            return self._handed_over(self._report)
        if self._finishing is not None:
            raise StateConflict("the recording is being finished already", state=str(self.state))
        self._finishing = _Finishing(caller, time.monotonic() + timeout_s, expected)
        return None

    # -- answers that come later ----------------------------------------------------------------

    def _answer_trigger(self, session: CaptureSession) -> None:
        waiting, intake = self._triggering, session.intake
        if waiting is None:
            return
        if intake.account.recorded > waiting.recorded:
            answer = self._next_of_group(session, waiting.caller)
            if answer is None:
                return
        elif intake.failure is not None:
            answer = _refusal(intake.failure)
        elif intake.account.refused > waiting.refused:
            answer = _refusal(CameraError("the frame arrived incomplete; trigger again"))
        elif time.monotonic() > waiting.deadline_s and not intake.in_flight:
            answer = _refusal(CameraError("no frame came of the trigger; is the camera triggered?"))
        else:
            return
        self._triggering = None
        waiting.caller.answer(answer)

    def _next_of_group(self, session: CaptureSession, caller: Caller) -> dict[str, Any] | None:
        """Go on with the group; return the answer where it is complete, or cannot be."""
        camera = self._keeper.camera
        if not session.sequencer.more:
            return {"frame_id": session.intake.last_recorded_id}
        if camera is None:
            return _refusal(CameraError("the camera was lost within a sequence; trigger again"))
        try:
            self._fire(session, camera, caller)
        except StationError as error:
            return _refusal(error)
        return None

    def _answer_finish(self, session: CaptureSession) -> None:
        waiting = self._finishing
        if waiting is not None:
            late = time.monotonic() > waiting.deadline_s
            if late or session.reached or session.quiet(waiting.expected):
                self._finishing = None
                self._conclude(session, waiting.expected)
                if self._report is not None:
                    waiting.caller.answer(self._handed_over(self._report))
        elif session.reached and self._report is None:
            self._conclude(session, expected=None)

    def _conclude(self, session: CaptureSession, expected: int | None) -> None:
        if self._report is None:
            self._report = session.finish(self._keeper.camera, expected)

    def _handed_over(self, report: CaptureReport) -> dict[str, Any]:
        self._drop_session()
        return {"report": report.to_json()}

    # -- the camera -----------------------------------------------------------------------------

    def _watch_camera(self) -> None:
        """Notice that the camera is lost; open it again."""
        session = self._session if self._report is None else None
        heard_s = 0.0 if session is None else session.intake.heard_s
        if self._keeper.is_check_due(heard_s):
            self._check_camera(session)
        elif self._keeper.is_due():
            try:
                camera, *_ = self._keeper.ensure_open()
                if session is not None:
                    session.camera_back(camera)
            except CameraError as error:
                self._keeper.drop(str(error))

    def _check_camera(self, session: CaptureSession | None) -> None:
        silent_s, allowed_s = 0.0, math.inf
        if session is not None:
            silent_s = time.monotonic() - session.intake.heard_s
            allowed_s = session.silence_allowed_s
        trouble = self._keeper.trouble(silent_s, allowed_s)
        if trouble is not None:
            if session is not None:
                session.camera_lost(trouble.kind, trouble.problem)
            self._keeper.drop(trouble.problem)
        elif session is not None and self._keeper.camera is not None:
            session.ask_clock(self._keeper.camera)


def _added(totals: dict[str, int], status: CaptureStatus) -> dict[str, int]:
    return {name: totals[name] + getattr(status, name) for name in _COUNTED}


def _refusal(error: StationError) -> dict[str, Any]:
    return {"error": type(error).__name__, "message": str(error), "state": None}


def run_capture(settings: SensorSettings, socket_path: Path) -> None:
    """Be the capture process of one sensor, until told to end by socket or SIGTERM.

    Ctrl-C at a terminal reaches every process of its group; who started this one decides.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    process = CaptureProcess(settings, socket_path)
    signal.signal(signal.SIGTERM, lambda *_: process.end())
    process.run()
