"""The job that recalibrates a sensor, step by step; each step may come twice and adds nothing then.

Deciding, acting and recording are one step, as they are one transaction: a calibration is in force
exactly where the recalibration says so.  What the steps hand on is in the recalibration's row.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import structlog

from station.errors import StationError, VersionConflict
from station.operations import bring_into_force, supersede_asking
from station.recalibration import Action, Decision, decide
from station.store import (
    JOB,
    RECALIBRATION,
    Actor,
    Job,
    JobState,
    Recalibration,
    RecalibrationState,
    active,
    end,
    the,
)
from station.worker.collecting import collect
from station.worker.context import WorkContext
from station.worker.evidence import evidence_of, note_comparison
from station.worker.piece_checking import check_piece_of
from station.worker.quiet import PatienceOut, Quiet
from station.worker.reporting import JobCancelled, begin, one_line
from station.worker.resolving import solve

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Step:
    """One step of the job, under the name by which the durable log knows it."""

    name: str
    do: Callable[[WorkContext, Recalibration, Quiet], None]


STEPS: Sequence[Step] = (
    Step("collect", collect),
    Step("solve", solve),
    Step("compare", note_comparison),
    Step("piece", check_piece_of),
)
"""What comes between taking the job up and deciding."""

_SHARE = 1.0 / (len(STEPS) + 1)


def take_up_recalibration(
    context: WorkContext, job_id: str, sleep: Callable[[float], None] = time.sleep
) -> None:
    """Take the job up once no train is being recorded or measured."""

    def take_up(row: Recalibration) -> None:
        Quiet(context, row, first=0.0, last=0.0, sleep=sleep).ensure()
        with context.store.change() as session:
            found = the(session, Recalibration, row.id)
            if found.state is RecalibrationState.WAITING:
                _step(found, RecalibrationState.RUNNING)
            present = active(session, found.sensor)
            if found.present_id is None and present is not None:
                found.present_id, found.present_version = present.calibration_id, present.version

    if begin(context, job_id) is not None:
        _guarded(context, job_id, take_up)


def do_step(
    context: WorkContext,
    job_id: str,
    place: int,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Do one of `STEPS`."""

    def do(row: Recalibration) -> None:
        quiet = Quiet(context, row, first=place * _SHARE, last=(place + 1) * _SHARE, sleep=sleep)
        STEPS[place].do(context, row, quiet)

    _guarded(context, job_id, do)


def conclude_recalibration(context: WorkContext, job_id: str) -> None:
    """Decide, act and record; then tell the worker of the passes to measure again."""
    _guarded(context, job_id, lambda row: _conclude(context, row))


def recalibrate(
    context: WorkContext, job_id: str, sleep: Callable[[float], None] = time.sleep
) -> None:
    """Do the whole job here and now, where no engine runs it."""
    take_up_recalibration(context, job_id, sleep)
    for place in range(len(STEPS)):
        do_step(context, job_id, place, sleep)
    conclude_recalibration(context, job_id)


def _guarded(context: WorkContext, job_id: str, do: Callable[[Recalibration], None]) -> None:
    with context.store.look() as session:
        job = the(session, Job, job_id)
        row = the(session, Recalibration, job.subject)
    if JOB.ended(job.state):
        return
    try:
        do(row)
    except JobCancelled:
        return
    except PatienceOut as error:
        fail_recalibration(context, job_id, str(error))
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        fail_recalibration(context, job_id, one_line(error, job_id))


def _conclude(context: WorkContext, row: Recalibration) -> None:
    settings = context.settings.recalibration
    decision = decide(evidence_of(context, row), settings.gates, settings.policy)
    try:
        _act(context, row.id, decision)
    except VersionConflict as error:
        raise StationError(
            f"{error}; sensor {row.sensor} keeps what came into force while it was recalibrated"
        ) from error
    _log.info(
        "sensor recalibrated",
        sensor=row.sensor,
        recalibration=row.id,
        outcome=decision.outcome.value,
        action=decision.action.value,
        alarm=decision.alarm,
        why="; ".join(decision.reasons),
    )


_STATE_AFTER = {
    Action.ACTIVATE: RecalibrationState.ACTIVATED,
    Action.KEEP: RecalibrationState.KEPT,
    Action.ASK: RecalibrationState.ASKING,
}


def _act(context: WorkContext, row_id: str, decision: Decision) -> None:
    with context.store.change() as session:
        row = the(session, Recalibration, row_id)
        job = the(session, Job, row.job_id)
        if job.state is not JobState.RUNNING:  # cancelled while the last step ran
            return
        row.outcome, row.action = decision.outcome.value, decision.action.value
        row.reasons = {"reasons": [*decision.reasons, *row.findings.get("remarks", [])]}
        row.figures, row.alarm = dict(decision.figures), decision.alarm
        if decision.action is Action.ACTIVATE:
            by = Actor(f"recalibration {row.id}")
            bring_into_force(session, context.settings, row, by=by, at=context.now())
        _step(row, _STATE_AFTER[decision.action])
        row.ended_at = context.now()
        if decision.outcome.tells:
            supersede_asking(session, row)
        end(job, JobState.DONE, at=context.now())


def fail_recalibration(context: WorkContext, job_id: str, why: str) -> None:
    """End a recalibration without a decision; the calibration in force stays."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if JOB.ended(job.state):
            return
        row = the(session, Recalibration, job.subject)
        _step(row, RecalibrationState.FAILED)
        row.reason, row.ended_at = why, context.now()
        end(job, JobState.FAILED, at=context.now(), error=why)
    _log.warning("sensor not recalibrated", sensor=row.sensor, recalibration=row.id, why=why)


def _step(row: Recalibration, wanted: RecalibrationState) -> None:
    RECALIBRATION.check(row.id, row.state, wanted)
    row.state = wanted
    row.version += 1
