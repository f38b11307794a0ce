"""One sensor's camera and the recording that is made with it, turn by turn."""

import math
import time
from dataclasses import dataclass, replace

import structlog

from station.capture.camera import ControlHeld
from station.capture.control import Answer, refusal
from station.capture.keeper import CameraKeeper
from station.capture.look import Look
from station.capture.looking import take_look
from station.capture.plan import CaptureReport, RecordingPlan, Trigger
from station.capture.session import CaptureSession
from station.capture.status import CaptureState, CaptureStatus
from station.capture.triggering import Triggering
from station.errors import CameraError, CameraLost, CameraRefused, StateConflict, StationError
from station.recording import EventKind
from station.settings import SensorSettings

_COUNTED = ("recorded", "lost", "refused", "repeated", "resent_packets")
_log = structlog.get_logger()


_CONTROL_LASTS_S = 4.0
"""A camera obeys a program that was killed until it has missed its heartbeat for 3 s."""


@dataclass(frozen=True, slots=True)
class _Arming:
    """A caller that waits for the camera to be free of the capture process before this one."""

    plan: RecordingPlan
    answer: Answer


@dataclass(frozen=True, slots=True)
class _Finishing:
    """A caller that waits for the report."""

    answer: Answer
    deadline_s: float
    expected: int | None


class SensorCapture:
    """Keeps the camera open, records by plan, and answers callers when their frames are written.

    Nothing here waits for long: `step` is to be called again and again.
    """

    def __init__(self, settings: SensorSettings) -> None:
        self._sensor = settings.id
        self._keeper = CameraKeeper(settings)
        self._session: CaptureSession | None = None
        self._triggering: Triggering | None = None
        self._arming: _Arming | None = None
        self._finishing: _Finishing | None = None
        self._until_free_s = time.monotonic() + _CONTROL_LASTS_S
        self._report: CaptureReport | None = None
        self._totals = dict.fromkeys(_COUNTED, 0)

    @property
    def state(self) -> CaptureState:
        """The present state; it follows from what there is."""
        if self._report is not None:
            return CaptureState.RECORDED
        has_camera = self._keeper.camera is not None
        if self._session is not None:
            return CaptureState.RECORDING if has_camera else CaptureState.BLIND
        return CaptureState.IDLE if has_camera else CaptureState.UNAVAILABLE

    def status(self) -> CaptureStatus:
        """Return what is being done, and what was counted since the process began."""
        keeper = self._keeper
        base = CaptureStatus(self.state, self._sensor, keeper.problem, keeper.description)
        if keeper.camera is not None:
            warnings = tuple(text for _, text in keeper.camera.warnings)
            base = replace(base, warnings=warnings, temperature_c=keeper.temperature_c)
        if self._session is None:
            return replace(base, totals=self._totals)
        status = self._session.status(base)
        return replace(status, totals=_added(self._totals, status))

    def arm(self, plan: RecordingPlan, answer: Answer) -> None:
        """Open the recording and let the camera acquire; answer when it does.

        That is at once, unless the process before this one was killed and holds the camera still.

        Raises
        ------
        StateConflict
            If somebody arms the sensor already.
        CameraRefused
            If another program controls the camera, or it does not take what the plan asks.
        CameraError
            If it cannot be opened.
        RecordingError, InputUnusable
            If the recording cannot be begun.
        """
        if self._arming is not None:
            raise StateConflict("the sensor is being armed already", state=str(self.state))
        try:
            self._begin(plan)
        except ControlHeld as error:
            if time.monotonic() > self._until_free_s:
                raise CameraRefused(str(error)) from error
            self._arming = _Arming(plan, answer)
        else:
            answer({})

    def _begin(self, plan: RecordingPlan) -> None:
        camera, ring, link = self._keeper.ensure_open()
        self._drop_session()
        self._session = CaptureSession(plan, camera, ring, link)
        _log.info("recording began", **_names(plan), trigger=str(plan.trigger))
        self._triggering = Triggering(self._session)

    def look(self) -> Look:
        """Take one picture that is recorded nowhere; see `take_look`.

        The camera is idle, or waits for a command to record the next pose of a target.

        Raises
        ------
        StateConflict
            If a recording runs that does not allow it, or takes a frame just now.
        """
        session = self._session
        if session is not None:
            self._ensure_lookable(session)
        camera, ring, _ = self._keeper.ensure_open()
        try:
            return take_look(camera, ring) if session is None else session.look(camera)
        except CameraLost as error:
            if session is not None:
                session.camera_lost(EventKind.CAMERA_LOST, str(error))
            self._keeper.drop(str(error))
            raise

    def _ensure_lookable(self, session: CaptureSession) -> None:
        if not session.plan.looks:
            raise StateConflict(
                f"sensor {self._sensor} is recording; `look` needs it to be idle, or in a "
                "calibration session",
                state=str(self.state),
            )
        taking = self._triggering is not None and self._triggering.busy
        if taking or self._finishing is not None:
            raise StateConflict("a picture is being taken; look again", state=str(self.state))

    def trigger(self, answer: Answer) -> None:
        """Take a frame, or a group of them; answer with the last one's id.

        Raises
        ------
        StateConflict
            If the recording is not triggered by software, the camera is away, or a frame is being
            taken already.
        CameraError
            If the camera does not take the trigger.
        """
        session, camera, triggering = self._session, self._keeper.camera, self._triggering
        by_software = session is not None and session.plan.trigger is Trigger.SOFTWARE
        if triggering is None or camera is None or not by_software:
            raise StateConflict("the recording's trigger is not `software`", state=str(self.state))
        triggering.begin(camera, answer)

    def finish(self, expected: int | None, timeout_s: float, answer: Answer) -> None:
        """Wait for the last frames and close the recording; answer with the report.

        Parameters
        ----------
        expected
            Frames that are to come in all, where they were counted.
        timeout_s
            How long they are waited for at most.
        answer
            Takes the report.

        Raises
        ------
        StateConflict
            If somebody finishes it already.
        """
        if self._report is not None:
            self._hand_over(self._report, answer)
            return
        if self._finishing is not None:
            raise StateConflict("the recording is being finished already", state=str(self.state))
        self._finishing = _Finishing(answer, time.monotonic() + timeout_s, expected)

    def step(self) -> None:
        """Take the frames that have come, answer who waits for them, look after the camera."""
        if self._arming is not None and self._keeper.is_due():
            self._arm_again(self._arming)
        if self._session is not None:
            self._session.intake.step()
        if self._triggering is not None:
            self._triggering.step(self._keeper.camera)
        if self._session is not None:
            self._finish_when_due(self._session)
        self._watch_camera()

    def _arm_again(self, waiting: _Arming) -> None:
        self._arming = None
        try:
            self.arm(waiting.plan, waiting.answer)
        except StationError as error:
            waiting.answer(refusal(error))

    def close(self) -> None:
        """Finish a recording under way and let go of the camera."""
        if self._session is not None:
            self._conclude(self._session, expected=None)
        self._keeper.close()

    # -- the end of a recording -----------------------------------------------------------------

    def _finish_when_due(self, session: CaptureSession) -> None:
        waiting = self._finishing
        if waiting is not None:
            late = time.monotonic() > waiting.deadline_s
            if late or session.reached or session.quiet(waiting.expected):
                self._finishing = None
                self._hand_over(self._conclude(session, waiting.expected), waiting.answer)
        elif session.reached:
            self._conclude(session, expected=None)

    def _conclude(self, session: CaptureSession, expected: int | None) -> CaptureReport:
        if self._report is None:
            self._report = session.finish(self._keeper.camera, expected)
            if self._triggering is not None:
                self._triggering.end()
            _log_end(session.plan, self._report)
        return self._report

    def _hand_over(self, report: CaptureReport, answer: Answer) -> None:
        self._drop_session()
        answer({"report": report.to_json()})

    def _drop_session(self) -> None:
        """Let go of a recording that is closed; what it counted stays in the totals."""
        if self._session is not None:
            blank = CaptureStatus(CaptureState.IDLE, self._sensor)
            self._totals = _added(self._totals, self._session.status(blank))
        self._session = self._triggering = self._report = None

    # -- the camera -----------------------------------------------------------------------------

    def _watch_camera(self) -> None:
        """Notice that the camera is lost; open it again."""
        session = self._session if self._report is None else None
        heard_s = 0.0 if session is None else session.intake.heard_s
        if self._keeper.is_check_due(heard_s):
            self._keeper.look_after_recorder()
            self._check_camera(session)
            if session is None:
                self._keeper.feel()
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


def _names(plan: RecordingPlan) -> dict[str, str]:
    """Return the names of a recording as the log has them."""
    return {name: plan.metadata[name] for name in ("recording", "pass") if name in plan.metadata}


def _log_end(plan: RecordingPlan, report: CaptureReport) -> None:
    say = _log.info if report.complete else _log.warning
    counts = {name: getattr(report, name) for name in ("triggered", *_COUNTED)}
    say("recording finished", **_names(plan), **counts, complete=report.complete)


def _added(totals: dict[str, int], status: CaptureStatus) -> dict[str, int]:
    return {name: totals[name] + getattr(status, name) for name in _COUNTED}
