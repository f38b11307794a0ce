"""The job that measures passes again with a calibration that came into force after them.

What was measured stays: a reading names its calibration, and the new ones stand beside the old.
"""

from collections.abc import Sequence

from sqlalchemy.orm import Session

from station.documents import CalibrationDocument
from station.limits import limits_of
from station.operations import last_good_check
from station.store import (
    JOB,
    Activation,
    Calibration,
    Job,
    JobState,
    Measurement,
    Recalibration,
    Recording,
    activation_of,
    end,
    the,
)
from station.store.measured import add_measurements
from station.store.recalibrations import recordings_under
from station.worker.context import WorkContext
from station.worker.measuring import StepResult
from station.worker.measuring_rig_again import measure_on_rig_again
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line
from station.worker.rows import measurement_row


def begin_measuring_again(context: WorkContext, job_id: str) -> list[str]:
    """Take the job up and return the recordings to measure; none where it has ended."""
    job = begin(context, job_id)
    if job is None:
        return []
    with context.store.look() as session:
        row = the(session, Recalibration, job.subject)
        present = _held_against(session, row)
        recordings = recordings_under(
            session, row.sensor, present.calibration_id, last_good_check(session, present)
        )
        return [each.id for each in recordings if each.recorded]


def _held_against(session: Session, row: Recalibration) -> Activation:
    return activation_of(session, row.sensor, row.present_version or 0)


def measure_recording_again(
    context: WorkContext, job_id: str, recording_id: str, *, place: int, of: int
) -> StepResult:
    """Measure one recording with the new calibration; a second time adds nothing."""
    try:
        rows = _measure(context, job_id, recording_id, place=place, of=of)
    except JobCancelled:
        return StepResult(recording=recording_id, refused="cancelled")
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        return StepResult(recording=recording_id, refused=one_line(error, job_id))
    with context.store.change() as session:
        if the(session, Job, job_id).state is JobState.RUNNING:
            add_measurements(session, rows)
    return StepResult(recording=recording_id, wheels=len(rows))


def _measure(
    context: WorkContext, job_id: str, recording_id: str, *, place: int, of: int
) -> list[Measurement]:
    with context.store.look() as session:
        subject = the(session, Job, job_id).subject
        new = the(session, Calibration, the(session, Recalibration, subject).calibration_id or "")
        recording = the(session, Recording, recording_id)
    progress = JobProgress(context, job_id, first=place / of, last=(place + 1) / of)
    if recording.rig_calibration_id is None:
        return _measure_alone(context, recording, new, progress)
    return measure_on_rig_again(context, recording, new, progress)


def _measure_alone(
    context: WorkContext, recording: Recording, new: Calibration, progress: JobProgress
) -> list[Measurement]:
    found = context.mathematics.measure(
        [context.layout.root / recording.path],
        CalibrationDocument.model_validate_json(new.document or ""),
        reference=context.settings.reference,
        limits=limits_of(context.settings.limits),
        progress=progress,
    )
    rows = [
        measurement_row(context, recording, wheel, place=at, found=found)
        for at, wheel in enumerate(found.wheels)
    ]
    for row in rows:
        row.calibration_id = new.id
    return rows


def conclude_measuring_again(
    context: WorkContext, job_id: str, results: Sequence[StepResult]
) -> None:
    """End the job: failed where nothing could be measured; the passes stay as they are."""
    refused = [f"{each['recording']}: {each['refused']}" for each in results if "refused" in each]
    if refused and len(refused) == len(results):
        fail_measuring_again(context, job_id, "; ".join(refused))
        return
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is JobState.RUNNING:
            end(job, JobState.DONE, at=context.now(), error="; ".join(refused) or None)


def fail_measuring_again(context: WorkContext, job_id: str, why: str) -> None:
    """End the job without new readings."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if not JOB.ended(job.state):
            end(job, JobState.FAILED, at=context.now(), error=why)
