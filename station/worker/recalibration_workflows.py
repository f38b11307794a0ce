"""Recalibrating, and measuring passes again, as durable workflows."""

from collections.abc import Callable

from dbos import DBOS

from station.store import JobKind
from station.worker.context import WorkContext
from station.worker.job_log import logged
from station.worker.measuring import StepResult
from station.worker.measuring_again import (
    begin_measuring_again,
    conclude_measuring_again,
    measure_recording_again,
)
from station.worker.perseverance import persevering
from station.worker.recalibrating import (
    STEPS,
    conclude_recalibration,
    do_step,
    take_up_recalibration,
)


def register_recalibrating(
    context: WorkContext, most_attempts: int
) -> dict[JobKind, Callable[[str], None]]:
    """Register both workflows with the engine."""

    @DBOS.step(name="take_up_recalibration")
    @persevering
    def take_up_step(job_id: str) -> None:
        take_up_recalibration(context, job_id)

    @DBOS.step(name="recalibration_step")
    @persevering
    def middle_step(job_id: str, place: int) -> None:
        do_step(context, job_id, place)

    @DBOS.step(name="conclude_recalibration")
    @persevering
    def conclude_step(job_id: str) -> None:
        conclude_recalibration(context, job_id)

    @DBOS.workflow(name=JobKind.RECALIBRATE.value, max_recovery_attempts=most_attempts)
    @logged(context)
    def recalibrate_workflow(job_id: str) -> None:
        take_up_step(job_id)
        for place in range(len(STEPS)):
            middle_step(job_id, place)
        conclude_step(job_id)

    return {
        JobKind.RECALIBRATE: recalibrate_workflow,
        JobKind.MEASURE_AGAIN: _register_measuring_again(context, most_attempts),
    }


def _register_measuring_again(context: WorkContext, most_attempts: int) -> Callable[[str], None]:
    @DBOS.step(name="begin_measuring_again")
    @persevering
    def begin_step(job_id: str) -> list[str]:
        return begin_measuring_again(context, job_id)

    @DBOS.step(name="measure_recording_again")
    @persevering
    def measure_step(job_id: str, recording: str, place: int, of: int) -> StepResult:
        return measure_recording_again(context, job_id, recording, place=place, of=of)

    @DBOS.step(name="conclude_measuring_again")
    @persevering
    def conclude_step(job_id: str, results: list[StepResult]) -> None:
        conclude_measuring_again(context, job_id, results)

    @DBOS.workflow(name=JobKind.MEASURE_AGAIN.value, max_recovery_attempts=most_attempts)
    @logged(context)
    def measure_again_workflow(job_id: str) -> None:
        recordings = begin_step(job_id)
        results = [
            measure_step(job_id, name, place, len(recordings))
            for place, name in enumerate(recordings)
        ]
        conclude_step(job_id, results)

    return measure_again_workflow
