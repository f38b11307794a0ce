"""What a station must answer a controller, worked out from what was asked of it before.

Every method tells the status of a call that is about to be made, and notes what it changes.  What
the sensors do is read from their doubles, which are the outside world.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from trackside import TrueCapture, frames_of

SENSORS = ("left", "right")
IN_PROGRESS = {"armed", "recording"}
OPEN = {"armed", "open"}


@dataclass
class KnownPass:
    train: str | None
    consist: list[str] | None
    named_coming: bool
    state: str = "recording"
    calibrated: tuple[str, ...] = ()
    job: str | None = None
    axles: int | None = None
    ended: bool = False
    """Somebody ended it; one that could not be armed nobody did."""
    blank: bool = True
    """No frame of it is accounted for."""

    @property
    def begins_again(self):
        return self.state == "failed" and not self.ended and self.blank


@dataclass
class KnownSession:
    sensor: str
    target: str
    state: str = "open"
    pictures: int = 0
    ended: bool = False


@dataclass
class KnownOrder:
    """A calibration or recalibration, and its job."""

    sensor: str
    job: str
    state: str


@dataclass
class Model:
    captures: Mapping[str, TrueCapture]
    root: object
    passes: dict[str, KnownPass] = field(default_factory=dict)
    sessions: dict[str, KnownSession] = field(default_factory=dict)
    calibrations: dict[str, KnownOrder] = field(default_factory=dict)
    recalibrations: dict[str, KnownOrder] = field(default_factory=dict)
    jobs: dict[str, str] = field(default_factory=dict)
    """States by id."""
    in_force: dict[str, int] = field(default_factory=dict)
    """Versions by sensor."""

    # -- passes ---------------------------------------------------------------------------------

    def put_pass(self, name, train, consist):
        known = self.passes.get(name)
        if known is not None:
            repeated = self._repeated_pass(known, train, consist)
            if not known.begins_again or not self._same_pass(known, train, consist):
                return repeated
        if self._pass_in_progress() or any(self._session_on(sensor) for sensor in SENSORS):
            return 409
        refusals = [self._beginning_refused(name, sensor) for sensor in SENSORS]
        new = KnownPass(train, consist, consist is not None, calibrated=tuple(self.in_force))
        new.state = "failed" if any(refusals) else "recording"
        self.passes[name] = new
        return next((each for each in refusals if each), 201)

    def finish_pass(self, name, axles, consist):
        known = self.passes.get(name)
        if known is None:
            return 404
        if known.state == "armed" or (known.state == "failed" and not known.ended):
            return 409
        told = ((known.consist, consist), (known.axles, axles))
        if any(None not in pair and pair[0] != pair[1] for pair in told):
            return 409
        known.consist = known.consist or consist
        known.axles = axles if known.axles is None else known.axles
        if known.state == "recording":
            known.state, known.ended = self._closed(name, known, known.axles), True
        return 200

    def _repeated_pass(self, known, train, consist):
        same = self._same_pass(known, train, consist)
        return 200 if same and known.state != "failed" else 409

    def _same_pass(self, known, train, consist):
        same = known.train == train
        if consist is not None or (known.consist is not None and known.named_coming):
            same = same and known.consist == consist
        return same

    def _closed(self, name, known, axles):
        frames = {sensor: self.frames_of("passes", name, sensor) for sensor in SENSORS}
        filled = {sensor for sensor, count in frames.items() if count}
        if not filled:
            return "done" if axles == 0 else "failed"
        return "measuring" if filled & set(known.calibrated) else "recorded"

    # -- sessions -------------------------------------------------------------------------------

    def put_session(self, name, sensor, target):
        known = self.sessions.get(name)
        if known is not None:
            same = (known.sensor, known.target) == (sensor, target)
            return 200 if same and known.state != "failed" else 409
        if self._pass_in_progress() or self._session_on(sensor):
            return 409
        refused = self._arming_refused(sensor)
        self.sessions[name] = KnownSession(sensor, target, "failed" if refused else "open")
        return refused or 201

    def capture(self, name):
        known = self.sessions.get(name)
        if known is None:
            return 404
        if known.state != "open":
            return 409
        capture = self.captures[known.sensor]
        if not capture.reachable:
            return 503
        if capture.plan is None:
            return 409
        known.pictures += 1
        return 200

    def finish_session(self, name):
        known = self.sessions.get(name)
        if known is None:
            return 404
        if known.state == "armed" or (known.state == "failed" and not known.ended):
            return 409
        if known.state == "open":
            known.state, known.ended = "recorded", True
        return 200

    # -- orders ---------------------------------------------------------------------------------

    def calibrate(self, sensor, session):
        known = self.sessions.get(session)
        if known is None:
            return 404
        if known.state != "recorded":
            return 409
        return 202 if known.sensor == sensor else 422

    def recalibrate(self, sensor):
        running = {
            each.sensor
            for each in self.recalibrations.values()
            if each.state in {"waiting", "running"}
        }
        if sensor in running:
            return 409
        self.recalibrations["not yet read"] = KnownOrder(sensor, "", "waiting")
        return 202

    def activate(self, sensor, calibration, seen):
        known = self.calibrations.get(calibration)
        if known is None:
            return 404
        if known.state != "ready":
            return 409
        if known.sensor != sensor:
            return 422
        present = self.in_force.get(sensor, 0)
        if seen is None and present:
            return 428
        if seen is not None and seen != present:
            return 412
        self.in_force[sensor] = present + 1
        return 200

    def cancel(self, job):
        state = self.jobs.get(job)
        if state is None:
            return 404
        if state in {"done", "failed"}:
            return 409
        self.end_job(job, "cancelled")
        return 200

    def end_job(self, job, state):
        """Have a job end, and what it worked on with it."""
        if self.jobs[job] == state:
            return
        self.jobs[job] = state
        for known in self.passes.values():
            if known.job == job:
                ends = {"done": known.state, "failed": "failed", "cancelled": "recorded"}
                known.state = ends[state]
        for orders, done in ((self.calibrations, "ready"), (self.recalibrations, "kept")):
            for order in orders.values():
                if order.job == job:
                    order.state = done if state == "done" else "failed"

    # -- sensors --------------------------------------------------------------------------------

    def frames_of(self, kind, name, sensor):
        """How many frames closing a recording finds: none where its sensor records on, unheard."""
        path = self.root / "recordings" / kind / name / f"{sensor}.mcap"
        capture = self.captures[sensor]
        runs = capture.plan is not None and capture.plan.path == path
        if runs and not capture.reachable:
            return 0
        return frames_of(path)

    def _beginning_refused(self, name, sensor):
        """A frame under a pass that failed is never put at risk."""
        path = self.root / "recordings" / "passes" / name / f"{sensor}.mcap"
        return self._arming_refused(sensor) or (409 if frames_of(path) else 0)

    def _arming_refused(self, sensor):
        return 0 if self.captures[sensor].reachable else 503

    def _pass_in_progress(self):
        return any(known.state in IN_PROGRESS for known in self.passes.values())

    def _session_on(self, sensor):
        return any(
            known.sensor == sensor and known.state in OPEN for known in self.sessions.values()
        )
