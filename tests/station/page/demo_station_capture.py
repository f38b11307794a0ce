"""A capture process's place taken by films: what it records is real, and so is how it accounts."""

import os
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from demo_station_truth import HEIGHT_PX, WIDTH_PX

from calib import Picture
from station.capture import CaptureReport, CaptureState, CaptureStatus, RecordingPlan, Trigger
from station.capture.accounting import FrameAccount
from station.capture.look import Look
from station.errors import StateConflict
from station.recording import CameraNumbers, Event, EventKind, RotatingWriter
from station.software import SOFTWARE


@dataclass(frozen=True)
class Exposure:
    """A picture that a camera takes; None of a frame that gets lost."""

    picture: Picture | None
    at_ns: int | None = None
    """When; None where it is triggered by a command, and taken then."""


class FilmedCapture:
    """One sensor, before whose camera a film is shown."""

    def __init__(self, sensor: str, now_ns: Callable[[], int]) -> None:
        self._sensor, self._now_ns = sensor, now_ns
        self._camera = {
            "vendor": "Treadline",
            "model": "film",
            "serial": f"DEMO-{sensor}",
            "width": str(WIDTH_PX),
            "height": str(HEIGHT_PX),
            "pixel_format": "Mono8",
            "exposure_us": "100.0",
            "gain_db": "0.0",
        }
        self._film: deque[Exposure] = deque()
        self._plan: RecordingPlan | None = None
        self._totals = dict.fromkeys(("recorded", "lost", "refused", "repeated"), 0)

    def show(self, film: Iterable[Exposure]) -> None:
        """Have the camera see this from now on."""
        self._film = deque(film)

    def status(self) -> CaptureStatus:
        plan = self._plan
        return CaptureStatus(
            CaptureState.IDLE if plan is None else CaptureState.RECORDING,
            self._sensor,
            camera=self._camera,
            session_id=None if plan is None else plan.session_id,
            path=None if plan is None else plan.path,
            recording_s=None if plan is None else 0.0,
            silent_s=None if plan is None else 0.0,
            recorded=0 if plan is None else self._account.recorded,
            lost=0 if plan is None else self._account.lost,
            totals=self._totals,
        )

    def arm(self, plan: RecordingPlan) -> None:
        if self._plan is not None:
            raise StateConflict("a recording runs already", state="recording")
        document = plan.attachments.get("calibration.json")
        session = {"id": plan.session_id, "sensor": plan.sensor, "trigger": str(plan.trigger)}
        self._writer = RotatingWriter(
            plan.path,
            plan.sensor,
            rotation=plan.rotation,
            metadata={
                "station": {"software": SOFTWARE, "host": "demo"},
                "session": {**session, **plan.metadata},
                "camera": {**self._camera, "sensor": plan.sensor},
            },
            attachments=plan.attachments,
            camera=None if document is None else partial(CameraNumbers.of_calibration, document),
            now_ns=self._now_ns,
        )
        self._plan, self._events, self._triggered = plan, list[Event](), 0
        self._account = FrameAccount(self._now_ns, self._note)
        self._note(Event(EventKind.STARTED, self._now_ns(), plan.session_id))

    def trigger(self) -> int:
        if self._plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        self._expose()
        return self._account.recorded

    def finish(self, expected_frames: int | None = None) -> CaptureReport:
        if self._plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        plan = self._plan
        if (
            plan.trigger is not Trigger.SOFTWARE
        ):  # the whole film has been seen by the end of a pass
            while self._film:
                self._expose()
        account = self._account
        account.close(expected_frames)
        self._note(Event(EventKind.FINISHED, self._now_ns(), plan.session_id))
        report = self._report(expected_frames)
        told = report.to_json()
        names = ("triggered", "recorded", "lost", "refused", "repeated", "complete")
        self._writer.finish({name: str(told[name]) for name in names})
        self._plan = None
        for name in self._totals:
            self._totals[name] += getattr(account, name)
        return report

    def look(self) -> Look:
        if self._plan is not None and not self._plan.looks:
            raise StateConflict("a recording runs; look when it is over", state="recording")
        seen = next(each.picture for each in self._film if each.picture is not None)
        descriptor = os.memfd_create("look")
        with os.fdopen(descriptor, "wb", closefd=False) as memory:
            memory.write(np.ascontiguousarray(seen).data)
        height, width = seen.shape
        return Look(descriptor, width, height, self._now_ns())

    def _expose(self) -> None:
        exposure = self._film.popleft()
        self._triggered += 1
        if exposure.picture is None:
            return
        time_ns = self._now_ns() if exposure.at_ns is None else exposure.at_ns
        self._account.arrive(self._triggered, None)
        picture = np.ascontiguousarray(exposure.picture)
        height, width = picture.shape
        self._writer.write_frame(
            self._triggered, time_ns, time_ns, picture.data.cast("B"), width, height
        )
        self._account.confirm()

    def _note(self, event: Event) -> None:
        self._events.append(event)
        self._writer.write_event(event)

    def _report(self, triggered: int | None) -> CaptureReport:
        assert self._plan is not None
        account = self._account
        return CaptureReport(
            path=self._plan.path,
            triggered=triggered,
            recorded=account.recorded,
            lost=account.lost,
            refused=account.refused,
            repeated=account.repeated,
            resent_packets=0,
            first_time_ns=None,
            last_time_ns=None,
            events=tuple(self._events),
        )
