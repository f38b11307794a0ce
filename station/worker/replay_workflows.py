"""Replaying as a durable workflow."""

from collections.abc import Callable

from dbos import DBOS

from station.store import JobKind
from station.worker.context import WorkContext
from station.worker.job_log import logged
from station.worker.perseverance import persevering
from station.worker.replaying import begin_replay, conclude_replay, replay_step


def register_replaying(
    context: WorkContext, most_attempts: int
) -> dict[JobKind, Callable[[str], None]]:
    """Register the workflow with the engine."""

    @DBOS.step(name="begin_replay")
    @persevering
    def begin_step(job_id: str) -> int:
        return begin_replay(context, job_id)

    @DBOS.step(name="replay_step")
    @persevering
    def measure_step(job_id: str, place: int) -> None:
        replay_step(context, job_id, place)

    @DBOS.step(name="conclude_replay")
    @persevering
    def conclude_step(job_id: str) -> None:
        conclude_replay(context, job_id)

    @DBOS.workflow(name=JobKind.REPLAY.value, max_recovery_attempts=most_attempts)
    @logged(context)
    def replay_workflow(job_id: str) -> None:
        for place in range(begin_step(job_id)):
            measure_step(job_id, place)
        conclude_step(job_id)

    return {JobKind.REPLAY: replay_workflow}
