"""One recording being made, from the first exposure to the report."""

import socket
import time
from dataclasses import replace

from station.capture.camera import Camera
from station.capture.clock import CameraClock
from station.capture.intake import Intake
from station.capture.link import RecorderDied, RecorderLink
from station.capture.plan import CaptureReport, RecordingPlan, Trigger
from station.capture.ring import Ring
from station.capture.status import CaptureStatus
from station.errors import StationError
from station.recording import Event, EventKind
from station.software import SOFTWARE

_QUIET_S = 1.0
"""A camera from which nothing came for so long has sent all that it was triggered for."""
_LAST_FRAMES_S = 0.3
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
        self.software_triggers = 0
        self._ring = ring
        self._link = link
        link.open(plan, _metadata(plan, camera))
        self.intake = Intake(link, range(ring.slots), plan.frames)
        try:
            self._start(camera)
        except StationError:
            link.discard()
            raise
        self._started_s = time.monotonic()
        self.intake.note(Event(EventKind.STARTED, time.time_ns(), plan.session_id))

    @property
    def reached(self) -> bool:
        """Whether what was planned is done."""
        account, plan = self.intake.account, self.plan
        if plan.frames is not None and account.accounted >= plan.frames:
            return True
        return plan.seconds is not None and time.monotonic() - self._started_s >= plan.seconds

    def status(self, base: CaptureStatus) -> CaptureStatus:
        """Return the process's status with this recording in it."""
        account = self.intake.account
        return replace(
            base,
            session_id=self.plan.session_id,
            path=self.plan.path,
            recorded=account.recorded,
            lost=account.lost,
            refused=account.refused,
            repeated=account.repeated,
        )

    def trigger(self, camera: Camera) -> None:
        """Expose once."""
        camera.trigger()
        self.software_triggers += 1

    def quiet(self, expected: int | None) -> bool:
        """Whether nothing more is to be waited for, `expected` frames being asked for."""
        if expected is None and self.plan.trigger is Trigger.SOFTWARE:
            expected = self.software_triggers
        if self.plan.trigger is Trigger.FREE and expected is None:
            return True
        if expected is not None and self.intake.account.accounted >= expected:
            return True
        silent_s = time.monotonic() - self.intake.heard_s
        return silent_s >= _QUIET_S and not self.intake.in_flight

    def camera_lost(self, reason: str) -> None:
        """Go on without a camera; what it exposes meanwhile is unknown."""
        self.intake.detach(lost=True)
        self.intake.note(Event(EventKind.CAMERA_LOST, time.time_ns(), reason))

    def camera_back(self, camera: Camera) -> None:
        """Go on with the camera, opened again."""
        self.intake.account.begin_again()
        self.intake.note(Event(EventKind.CAMERA_BACK, time.time_ns(), "opened again"))
        self._start(camera)

    def finish(self, camera: Camera | None, expected: int | None) -> CaptureReport:
        """Stop acquiring, see the last frames into the file, and close it."""
        self._stop(camera)
        intake = self.intake
        triggered = expected
        if triggered is None and self.plan.trigger is Trigger.SOFTWARE:
            triggered = self.software_triggers
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

    def _start(self, camera: Camera) -> None:
        free = self.intake.free_slots
        stream = camera.start(self.plan.trigger, self._ring, free)
        self.intake.attach(stream, CameraClock(camera.tick_frequency_hz))

    def _stop(self, camera: Camera | None) -> None:
        if camera is not None:
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
            self.intake.revive()
            self._settle()
            return self._link.finish(accounting)

    def _report(self, triggered: int | None) -> CaptureReport:
        intake, account = self.intake, self.intake.account
        return CaptureReport(
            path=self.plan.path,
            triggered=triggered,
            recorded=account.recorded,
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
