"""The jobs as durable workflows: a step that is done stays done, whatever kills the worker.

DBOS keeps one registry of workflows in a process, so they are registered once, with the context
they work in, by the worker process alone.
"""

import sqlite3
from collections.abc import Callable

import structlog
from dbos import DBOS, DBOSConfig, SetWorkflowID

from station.errors import StoreUnusable
from station.store import Job, JobKind, JobState, unfinished_jobs
from station.worker.calibrating import calibrate, fail_calibration
from station.worker.calibrating_rig import calibrate_rig, fail_rig_calibration
from station.worker.context import WorkContext
from station.worker.housekeeping import fail_housekeeping
from station.worker.housekeeping_workflows import register_housekeeping
from station.worker.job_log import logged
from station.worker.measuring import (
    StepResult,
    begin_measuring,
    conclude_measuring,
    fail_measuring,
    measure_step,
)
from station.worker.measuring_again import fail_measuring_again
from station.worker.perseverance import persevering
from station.worker.queue import APPLICATION, APPLICATION_VERSION, EXECUTOR_ID
from station.worker.recalibrating import fail_recalibration
from station.worker.recalibration_workflows import register_recalibrating
from station.worker.replay_workflows import register_replaying
from station.worker.replaying import fail_replay

_MOST_ATTEMPTS = 5
_POLLING_S, _SELDOM_POLLING_S = 0.1, 0.5
"""How often each queue is looked into: readings are waited for.  Looking ten times a second into
those of all kinds of jobs took a seventh of a core of a station at rest."""
_GIVEN_UP = {"ERROR", "CANCELLED", "MAX_RECOVERY_ATTEMPTS_EXCEEDED"}
_FAIL: dict[JobKind, Callable[[WorkContext, str, str], None]] = {
    JobKind.CALIBRATE: fail_calibration,
    JobKind.CALIBRATE_RIG: fail_rig_calibration,
    JobKind.MEASURE: fail_measuring,
    JobKind.RECALIBRATE: fail_recalibration,
    JobKind.MEASURE_AGAIN: fail_measuring_again,
    JobKind.REPLAY: fail_replay,
    JobKind.RETENTION: fail_housekeeping,
    JobKind.COMPACT: fail_housekeeping,
}
_log = structlog.get_logger()


class Workflows:
    """The running workflow engine of the worker process."""

    def __init__(self, context: WorkContext) -> None:
        self._context = context
        # The engine leaves SQLite's rollback journal on, in which a reader holds up a writer;
        # the mode stays in the file.
        with sqlite3.connect(context.layout.jobs_file) as connection:
            connection.execute("PRAGMA journal_mode = WAL")
        connection.close()
        DBOS(
            config=DBOSConfig(
                name=APPLICATION,
                system_database_url=context.layout.jobs_url,
                executor_id=EXECUTOR_ID,
                application_version=APPLICATION_VERSION,
                log_level="WARNING",
            )
        )
        self._workflows = _register(context)

    def launch(self) -> None:
        """Start the engine: what a killed worker left is taken up at once."""
        DBOS.launch()
        for kind in JobKind:
            often_s = _POLLING_S if kind is JobKind.MEASURE else _SELDOM_POLLING_S
            DBOS.register_queue(kind.value, worker_concurrency=1, polling_interval_sec=often_s)

    def take_in(self) -> None:
        """Bring store and engine together: queue what nobody queued, end what was given up."""
        with self._context.store.look() as session:
            jobs = unfinished_jobs(session)
        for job in jobs:
            known = DBOS.get_workflow_status(job.id)
            if known is None:
                with SetWorkflowID(job.id):
                    DBOS.enqueue_workflow(job.kind, self._workflows[JobKind(job.kind)], job.id)
            elif known.status in _GIVEN_UP:
                self._fail(job, f"the worker ended it ({known.status.lower()}); order it again")

    def _fail(self, job: Job, why: str) -> None:
        _FAIL[JobKind(job.kind)](self._context, job.id, why)

    def stop(self, patience_s: int) -> None:
        """Stop the engine; a step not done in time is done again after the next start."""
        try:
            with self._context.store.look() as session:
                busy = any(job.state is JobState.RUNNING for job in unfinished_jobs(session))
        except StoreUnusable:
            busy = True  # a step may be waiting for the store, and is done after the next start
        # Asked to wait at all, the engine waits for a second at least.
        DBOS.destroy(workflow_completion_timeout_sec=patience_s if busy else 0)


def _register(context: WorkContext) -> dict[JobKind, Callable[[str], None]]:
    @DBOS.step(name="calibrate")
    @persevering
    def solve_step(job_id: str) -> None:
        calibrate(context, job_id)

    @DBOS.step(name="begin_measuring")
    @persevering
    def begin_step(job_id: str) -> list[str]:
        return begin_measuring(context, job_id)

    # Its name is of a time when a step was always one recording; a log that names it goes on.
    @DBOS.step(name="measure_recording")
    @persevering
    def measuring_step(job_id: str, step: str, place: int, of: int) -> StepResult:
        return measure_step(context, job_id, step, place=place, of=of)

    @DBOS.step(name="conclude_measuring")
    @persevering
    def conclude_step(job_id: str, results: list[StepResult]) -> None:
        conclude_measuring(context, job_id, results)

    @DBOS.workflow(name=JobKind.CALIBRATE.value, max_recovery_attempts=_MOST_ATTEMPTS)
    @logged(context)
    def calibrate_workflow(job_id: str) -> None:
        solve_step(job_id)

    @DBOS.workflow(name=JobKind.MEASURE.value, max_recovery_attempts=_MOST_ATTEMPTS)
    @logged(context)
    def measure_workflow(job_id: str) -> None:
        steps = begin_step(job_id)
        results = [
            measuring_step(job_id, step, place, len(steps)) for place, step in enumerate(steps)
        ]
        conclude_step(job_id, results)

    @DBOS.step(name="calibrate_rig")
    @persevering
    def solve_rig_step(job_id: str) -> None:
        calibrate_rig(context, job_id)

    @DBOS.workflow(name=JobKind.CALIBRATE_RIG.value, max_recovery_attempts=_MOST_ATTEMPTS)
    @logged(context)
    def calibrate_rig_workflow(job_id: str) -> None:
        solve_rig_step(job_id)

    return {
        JobKind.CALIBRATE: calibrate_workflow,
        JobKind.CALIBRATE_RIG: calibrate_rig_workflow,
        JobKind.MEASURE: measure_workflow,
        **register_recalibrating(context, _MOST_ATTEMPTS),
        **register_replaying(context, _MOST_ATTEMPTS),
        **register_housekeeping(context, _MOST_ATTEMPTS),
    }
