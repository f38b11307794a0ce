"""One recording being made, from the first exposure to the report."""

import math
import socket
import time
from dataclasses import replace

from station.capture.camera import Camera
from station.capture.clock import CameraClock, ClockSource
from station.capture.intake import Intake
from station.capture.link import RecorderDied, RecorderLink
from station.capture.look import Look
from station.capture.looking import take_look
from station.capture.plan import CaptureReport, RecordingPlan, Trigger
from station.capture.ring import Ring
from station.capture.sequence import Sequencer
from station.capture.status import CaptureState, CaptureStatus
from station.errors import StateConflict, StationError
from station.recording import Event, EventKind
from station.software import SOFTWARE

_QUIET_S = 1.0
"""A camera from which nothing came for so long has sent all that it was triggered for."""
_LAST_FRAMES_S = 0.3
_FIRST_CLOCK_SAMPLES = 3
"""The first answer may have waited for anything; the quickest of a few has not."""
_MISSING_PERIODS, _SHORTEST_STALL_S = 10, 2.0
"""A camera in free run that answers and sends nothing for so long is opened again."""
_LAST_ANSWERS_S = 10.0
_PATIENCES = 2


class CaptureSession:
    """Carries out one plan.  The file is open and the camera acquires once it exists."""

    def __init__(self, plan: RecordingPlan, camera: Camera, ring: Ring, link: RecorderLink) -> None:
        """Open the file, then let the camera acquire.

        Raises
        ------
        InputUnusable
            If the recording exists or its folder does not take it.
        CameraError
            If the camera does not start.
        """
        self.plan = plan
        self.sequencer = Sequencer(plan.sequence)
        self._ring = ring
        self._link = link
        self._resting = False
        link.open(plan, _metadata(plan, camera))
        self.intake = Intake(
            link, range(ring.slots), plan.frames, exposure_of=self.sequencer.values_of
        )
        if plan.goes_on is not None:
            self.intake.account.go_on(plan.goes_on)
        try:
            self._start(camera)
        except StationError:
            link.discard()
            raise
        self._started_s = time.monotonic()
        self._note_beginning()
        self._say_warnings(camera)

    @property
    def reached(self) -> bool:
        """Whether what was planned is done."""
        account, plan = self.intake.account, self.plan
        if plan.frames is not None and account.accounted >= plan.frames:
            return True
        return plan.seconds is not None and time.monotonic() - self._started_s >= plan.seconds

    def status(self, base: CaptureStatus) -> CaptureStatus:
        """Return the process's status with this recording in it."""
        account, now_s = self.intake.account, time.monotonic()
        last_s = self._started_s if self.intake.frame_s is None else self.intake.frame_s
        return replace(
            base,
            session_id=self.plan.session_id,
            path=self.plan.path,
            recording_s=now_s - self._started_s,
            silent_s=now_s - last_s,
            recorded=account.recorded,
            lost=account.lost,
            refused=account.refused,
            repeated=account.repeated,
            resent_packets=self.intake.packets_resent(),
            ring_slots=self._ring.slots,
            ring_waiting=self.intake.unwritten,
            clock=self.intake.clock.summary().to_text(),
        )

    def ask_clock(self, camera: Camera) -> None:
        """Compare the camera's clock with this host's; costs a millisecond."""
        sample = camera.clock_sample()
        if sample is not None:
            self.intake.learn_time(sample)

    def look(self, camera: Camera) -> Look:
        """Take one picture that is not recorded, between two triggers; see `take_look`.

        The camera then rests, until `wake`: who looks again and again has it started once a look.

        Raises
        ------
        StateConflict
            If frames of the recording are on their way.
        CameraLost, CameraError
            As of `take_look`; the recording is as it was.
        """
        if not self._resting:
            self._rest(camera)
        return take_look(camera, self._ring)

    def wake(self, camera: Camera) -> None:
        """Have a camera that somebody looked through acquire again; raises what the camera does.

        It numbers its frames anew; in the recording they go on behind the last one.
        """
        if self._resting:
            self.intake.account.begin_again()
            self._start(camera)

    def _rest(self, camera: Camera) -> None:
        if self.intake.in_flight or self.intake.unwritten:
            raise StateConflict(
                "frames of the recording are on their way; look again",
                state=str(CaptureState.RECORDING),
            )
        self._stop(camera)
        self._settle()  # the look needs a slot of the ring in which nothing waits to be written
        self._resting = True

    @property
    def silence_allowed_s(self) -> float:
        """How long a camera that is well may send nothing; without end where it is triggered."""
        return self._silence_allowed_s

    def quiet(self, expected: int | None) -> bool:
        """Whether nothing more is to be waited for, `expected` frames being asked for."""
        if expected is None and self.plan.trigger is Trigger.SOFTWARE:
            expected = self.sequencer.triggered
        if self.plan.trigger is Trigger.FREE and expected is None:
            return True
        if expected is not None and self.intake.account.accounted >= expected:
            return True
        silent_s = time.monotonic() - self.intake.heard_s
        return silent_s >= _QUIET_S and not self.intake.in_flight

    def camera_lost(self, kind: EventKind, reason: str) -> None:
        """Go on without a camera; what it exposes meanwhile is unknown."""
        self.intake.detach(lost=True)
        self._lost_s = time.monotonic()
        silent_s = self._lost_s - self.intake.heard_s
        detail = f"{reason}; its last frame came {silent_s:.2f} s before"
        self.intake.note(Event(kind, time.time_ns(), detail))

    def camera_back(self, camera: Camera) -> None:
        """Go on with the camera, opened again."""
        self.intake.account.begin_again()
        away_s = time.monotonic() - self._lost_s
        detail = f"opened again {away_s:.2f} s after it was found lost"
        self.intake.note(Event(EventKind.CAMERA_BACK, time.time_ns(), detail))
        self._start(camera)
        self._say_warnings(camera)

    def finish(self, camera: Camera | None, expected: int | None) -> CaptureReport:
        """Stop acquiring, see the last frames into the file, and close it."""
        self._stop(camera)
        intake = self.intake
        triggered = expected
        if triggered is None and self.plan.trigger is Trigger.SOFTWARE:
            triggered = self.sequencer.triggered
        self._settle()
        intake.account.close(triggered)
        if intake.resent_packets:
            detail = "packets were lost on the way and sent again"
            kind, count = EventKind.PACKETS_RESENT, intake.resent_packets
            intake.note(Event(kind, time.time_ns(), detail, count=count))
        intake.note(Event(EventKind.FINISHED, time.time_ns(), self.plan.session_id))
        self._settle()
        self._close_file(self._report(triggered))
        return self._report(triggered)

    def _note_beginning(self) -> None:
        now_ns, before = time.time_ns(), self.plan.goes_on
        if before is None:
            self.intake.note(Event(EventKind.STARTED, now_ns, self.plan.session_id))
        else:
            self.intake.note(before.event(now_ns))

    def _start(self, camera: Camera) -> None:
        free = self.intake.free_slots
        exposure_us = camera.exposure_us
        self._silence_allowed_s = self._longest_silence_s(camera, exposure_us)
        stream = camera.start(self.plan.trigger, self._ring, free)
        self._resting = False
        self.sequencer.camera_started()
        self.intake.attach(stream, CameraClock(camera.tick_frequency_hz, round(exposure_us * 1e3)))
        for _ in range(_FIRST_CLOCK_SAMPLES):
            self.ask_clock(camera)

    def _longest_silence_s(self, camera: Camera, exposure_us: float) -> float:
        if self.plan.trigger is not Trigger.FREE:
            return math.inf
        period_s = max(1.0 / camera.frame_rate_hz, exposure_us * 1e-6)
        return max(_SHORTEST_STALL_S, _MISSING_PERIODS * period_s)

    def _say_warnings(self, camera: Camera) -> None:
        for kind, detail in camera.warnings:
            self.intake.note(Event(kind, time.time_ns(), detail))
        if self.intake.clock.source is ClockSource.HOST:
            detail = "the camera's clock has no tick frequency; frames bear the time of reception"
            self.intake.note(Event(EventKind.CLOCK_MISSING, time.time_ns(), detail))

    def _stop(self, camera: Camera | None) -> None:
        if camera is not None and not self._resting:
            camera.stop()
        deadline = time.monotonic() + _LAST_FRAMES_S
        while self.intake.in_flight and time.monotonic() < deadline:
            self.intake.step()
        self.intake.detach(lost=camera is None)

    def _settle(self) -> None:
        """Wait until the recorder has answered for every entry; replace one that is stuck."""
        for _ in range(_PATIENCES):
            deadline = time.monotonic() + _LAST_ANSWERS_S
            while self.intake.unwritten and time.monotonic() < deadline:
                self.intake.settle(timeout_s=0.1)
            if not self.intake.unwritten:
                return
            self._link.kill()

    def _close_file(self, report: CaptureReport) -> None:
        counts = report.to_json()
        names = ("triggered", "recorded", "lost", "refused", "repeated", "complete")
        accounting = {name: str(counts[name]) for name in names} | self.intake.receiving
        accounting |= self.intake.clock.summary().to_text()
        try:
            frames = self._finished_by_some_recorder(accounting)
        except StationError as error:
            self.intake.fail(error)
        else:
            self.intake.compare(frames)

    def _finished_by_some_recorder(self, accounting: dict[str, str]) -> int:
        try:
            return self._link.finish(accounting)
        except RecorderDied:
            finished = self._link.finished_unsaid()
            if finished is not None:
                return finished
            self.intake.revive()
            self._settle()
            return self._link.finish(accounting)

    def _report(self, triggered: int | None) -> CaptureReport:
        intake, account = self.intake, self.intake.account
        return CaptureReport(
            path=self.plan.path,
            paths=self._link.paths,
            triggered=triggered,
            recorded=account.earlier + account.recorded,
            lost=account.lost,
            refused=account.refused,
            repeated=account.repeated,
            resent_packets=intake.resent_packets,
            first_time_ns=intake.first_time_ns,
            last_time_ns=intake.last_time_ns,
            events=tuple(intake.events),
        )


def _metadata(plan: RecordingPlan, camera: Camera) -> dict[str, dict[str, str]]:
    return {
        "station": {"software": SOFTWARE, "host": socket.gethostname()},
        "session": {
            "id": plan.session_id,
            "sensor": plan.sensor,
            "trigger": str(plan.trigger),
            **plan.metadata,
        },
        "camera": {**camera.description(), "sensor": plan.sensor},
    }
