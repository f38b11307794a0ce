"""Deleting and compacting recordings as durable workflows."""

from collections.abc import Callable

from dbos import DBOS

from station.store import JobKind
from station.worker.context import WorkContext
from station.worker.housekeeping import (
    begin_compacting,
    compact_one,
    conclude_compacting,
    delete_what_is_due,
)
from station.worker.job_log import logged
from station.worker.perseverance import persevering


def register_housekeeping(
    context: WorkContext, most_attempts: int
) -> dict[JobKind, Callable[[str], None]]:
    """Register both workflows with the engine."""

    @DBOS.step(name="delete_what_is_due")
    @persevering
    def delete_step(job_id: str) -> None:
        delete_what_is_due(context, job_id)

    @DBOS.step(name="begin_compacting")
    @persevering
    def begin_step(job_id: str) -> list[str]:
        return begin_compacting(context, job_id)

    @DBOS.step(name="compact_recording")
    @persevering
    def compact_step(job_id: str, recording: str, place: int, of: int) -> None:
        compact_one(context, job_id, recording, place, of)

    @DBOS.step(name="conclude_compacting")
    @persevering
    def conclude_step(job_id: str) -> None:
        conclude_compacting(context, job_id)

    @DBOS.workflow(name=JobKind.RETENTION.value, max_recovery_attempts=most_attempts)
    @logged(context)
    def retention_workflow(job_id: str) -> None:
        delete_step(job_id)

    @DBOS.workflow(name=JobKind.COMPACT.value, max_recovery_attempts=most_attempts)
    @logged(context)
    def compact_workflow(job_id: str) -> None:
        recordings = begin_step(job_id)
        for place, recording in enumerate(recordings):
            compact_step(job_id, recording, place, len(recordings))
        conclude_step(job_id)

    return {JobKind.RETENTION: retention_workflow, JobKind.COMPACT: compact_workflow}
