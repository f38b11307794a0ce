"""The states of what the station keeps, and which may follow which.

A command that asks for a step not in the table is refused with the present state; nothing waits
in a queue for the state to change.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from station.errors import StateConflict


class PassState(StrEnum):
    """Where a pass of a train stands."""

    ARMED = "armed"
    RECORDING = "recording"
    RECORDED = "recorded"
    MEASURING = "measuring"
    DONE = "done"
    FAILED = "failed"
    RECOVERED = "recovered"


class EndedBy(StrEnum):
    """Who ended a pass or a calibration session."""

    CONTROLLER = "controller"
    """Its finish."""
    TIMEOUT = "timeout"
    """The station, as the controller was not heard of."""
    RESTART = "restart"
    """The station, as nothing recorded any more when it was started again."""


class SessionState(StrEnum):
    """Where a session of calibration pictures stands."""

    ARMED = "armed"
    OPEN = "open"
    RECORDED = "recorded"
    FAILED = "failed"


class CalibrationState(StrEnum):
    """Where a calibration stands."""

    SOLVING = "solving"
    READY = "ready"
    FAILED = "failed"


class JobState(StrEnum):
    """Where a job of the worker stands."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


class RecalibrationState(StrEnum):
    """Where a recalibration of a sensor stands."""

    WAITING = "waiting"
    RUNNING = "running"
    KEPT = "kept"
    ACTIVATED = "activated"
    ASKING = "asking"
    REFUSED = "refused"
    SUPERSEDED = "superseded"
    FAILED = "failed"


State = TypeVar("State", bound=StrEnum)


@dataclass(frozen=True, slots=True)
class Transitions(Generic[State]):
    """Which state may follow which."""

    kind: str
    allowed: Mapping[State, frozenset[State]]

    def check(self, name: str, present: State, wanted: State) -> None:
        """Let a step of the table pass.

        Raises
        ------
        StateConflict
            If the present state does not lead to the wanted one.
        """
        if wanted not in self.allowed[present]:
            follows = ", ".join(sorted(self.allowed[present])) or "nothing, it has ended"
            raise StateConflict(
                f"{self.kind} {name} is {present}, not to become {wanted}; allowed next: {follows}",
                state=present,
            )

    def ended(self, state: State) -> bool:
        """Tell whether nothing follows `state`."""
        return not self.allowed[state]

    @property
    def unfinished(self) -> tuple[State, ...]:
        """The states that something follows."""
        return tuple(state for state in self.allowed if not self.ended(state))


PASS = Transitions(
    "pass",
    {
        PassState.ARMED: frozenset({PassState.RECORDING, PassState.RECORDED, PassState.FAILED}),
        PassState.RECORDING: frozenset({PassState.RECORDED, PassState.FAILED}),
        # Done without measuring: the train did not come, and nothing was to be seen.
        PassState.RECORDED: frozenset({PassState.MEASURING, PassState.DONE, PassState.FAILED}),
        # Recorded again: the measuring was cancelled, the recording is as good as before.
        PassState.MEASURING: frozenset({
            PassState.DONE,
            PassState.RECOVERED,
            PassState.FAILED,
            PassState.RECORDED,
        }),
        PassState.DONE: frozenset(),
        # Armed again: nothing was recorded of it, and its controller tries once more.
        PassState.FAILED: frozenset({PassState.ARMED}),
        PassState.RECOVERED: frozenset(),
    },
)
"""A pass holds the sensors while it is armed or recording, and leaves these two states by itself:
by the controller's finish, by a time-out, or at a start of the station, whichever comes first.

armed
    Its rows are there, its sensors are being armed.  A call to finish it is refused.
recording
    Every sensor was armed.
recorded
    Closed, frames accounted for; to stay so where no calibration was in force or the measuring was
    cancelled.
measuring
    A job has it.
done, recovered
    Measured, or no wheel came; `recovered` is `done` from a recording that a crash had cut short.
failed
    A sensor did not arm, no frame was recorded, or the measuring failed.  What was recorded stays.
    The first alone, and only without a frame, leads back: to armed, by the same call again.

What the controller counted and named may come as long as it has not come: also after the end.
"""

SESSION = Transitions(
    "calibration session",
    {
        SessionState.ARMED: frozenset({
            SessionState.OPEN,
            SessionState.RECORDED,
            SessionState.FAILED,
        }),
        SessionState.OPEN: frozenset({SessionState.RECORDED, SessionState.FAILED}),
        SessionState.RECORDED: frozenset(),
        SessionState.FAILED: frozenset(),
    },
)
"""A session holds its sensors while it is armed or open, and leaves both by itself as a pass does.

With pictures it ends `recorded`, whoever ended it; without one it has `failed`, unless a person
finished it.
"""

CALIBRATION = Transitions(
    "calibration",
    {
        CalibrationState.SOLVING: frozenset({CalibrationState.READY, CalibrationState.FAILED}),
        CalibrationState.READY: frozenset(),
        CalibrationState.FAILED: frozenset(),
    },
)

JOB = Transitions(
    "job",
    {
        JobState.QUEUED: frozenset({JobState.RUNNING, JobState.FAILED, JobState.CANCELLED}),
        # Running again: the worker was killed in the middle and takes the job up once more.
        JobState.RUNNING: frozenset({
            JobState.RUNNING,
            JobState.DONE,
            JobState.FAILED,
            JobState.CANCELLED,
        }),
        JobState.DONE: frozenset(),
        JobState.FAILED: frozenset(),
        JobState.CANCELLED: frozenset(),
    },
)

RECALIBRATION = Transitions(
    "recalibration",
    {
        RecalibrationState.WAITING: frozenset({
            RecalibrationState.RUNNING,
            RecalibrationState.FAILED,
        }),
        RecalibrationState.RUNNING: frozenset({
            RecalibrationState.KEPT,
            RecalibrationState.ACTIVATED,
            RecalibrationState.ASKING,
            RecalibrationState.FAILED,
        }),
        # Superseded: a later one of the sensor has come to a decision before a person did.
        RecalibrationState.ASKING: frozenset({
            RecalibrationState.ACTIVATED,
            RecalibrationState.REFUSED,
            RecalibrationState.SUPERSEDED,
        }),
        RecalibrationState.KEPT: frozenset(),
        RecalibrationState.ACTIVATED: frozenset(),
        RecalibrationState.REFUSED: frozenset(),
        RecalibrationState.SUPERSEDED: frozenset(),
        RecalibrationState.FAILED: frozenset(),
    },
)
