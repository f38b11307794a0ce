"""The job that measures a pass, one recording a step."""

from collections.abc import Sequence
from typing import NotRequired, TypedDict

from sqlalchemy.orm import Session

from station.documents import CalibrationDocument, MeasurementDocument, WheelDocument
from station.limits import limits_of
from station.store import (
    PASS,
    Calibration,
    Job,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    add_measurements,
    end,
    recordings_of,
    the,
)
from station.trains import keep_axles
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line


class StepResult(TypedDict):
    """What a step hands on; plain data, as the durable log keeps it."""

    recording: str
    wheels: NotRequired[int]
    refused: NotRequired[str]


def begin_measuring(context: WorkContext, job_id: str) -> list[str]:
    """Take the job up and return the recordings to measure; none where it has ended."""
    job = begin(context, job_id)
    if job is None:
        return []
    with context.store.look() as session:
        recordings = recordings_of(session, the(session, Pass, job.subject))
        return [each.id for each in recordings if each.recorded and each.calibration_id]


def measure_recording(
    context: WorkContext, job_id: str, recording_id: str, *, place: int, of: int
) -> StepResult:
    """Measure the wheels of one recording and keep them; a second time adds nothing."""
    with context.store.look() as session:
        recording = the(session, Recording, recording_id)
        calibration = the(session, Calibration, recording.calibration_id or "")
    try:
        found = context.measure(
            [context.layout.root / recording.path],
            CalibrationDocument.model_validate_json(calibration.document or ""),
            reference=context.settings.reference,
            limits=limits_of(context.settings.limits),
            progress=JobProgress(context, job_id, first=place / of, last=(place + 1) / of),
        )
    except JobCancelled:
        return StepResult(recording=recording_id, refused="cancelled")
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        return StepResult(recording=recording_id, refused=one_line(error, job_id))
    rows = [
        _row(context, recording, wheel, place=at, found=found)
        for at, wheel in enumerate(found.wheels)
    ]
    with context.store.change() as session:
        if the(session, Job, job_id).state is JobState.RUNNING:
            add_measurements(session, rows)
    return StepResult(recording=recording_id, wheels=len(rows))


def _row(
    context: WorkContext,
    recording: Recording,
    wheel: WheelDocument,
    *,
    place: int,
    found: MeasurementDocument,
) -> Measurement:
    # A wheel without a frame of its own still needs a key: no camera gives a negative one.
    frame = wheel.frame if wheel.frame is not None else -1 - place
    return Measurement(
        recording_id=recording.id,
        frame=frame,
        calibration_id=recording.calibration_id,
        sensor=recording.sensor,
        pass_id=recording.pass_id,
        reference=found.reference,
        regime=found.regime,
        software=found.software,
        measured_at=context.now(),
        wheel=wheel.model_dump(mode="json"),
    )


def conclude_measuring(context: WorkContext, job_id: str, results: Sequence[StepResult]) -> None:
    """End the job and its pass: done, recovered, or failed where nothing could be measured."""
    refused = [f"{each['recording']}: {each['refused']}" for each in results if "refused" in each]
    if len(refused) == len(results):
        fail_measuring(context, job_id, "; ".join(refused) or "there was nothing to measure")
        return
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is not JobState.RUNNING:
            return
        row = the(session, Pass, job.subject)
        recordings = recordings_of(session, row)
        cut = any(recording.recovered for recording in recordings)
        _step(row, PassState.RECOVERED if cut else PassState.DONE)
        row.reason = "; ".join([*refused, *_unmeasured(recordings)]) or None
        _keep_axles(context, session, row)
        end(job, JobState.DONE, at=context.now())


def _unmeasured(recordings: Sequence[Recording]) -> list[str]:
    return [
        f"{recording.id}: "
        + ("no frame was recorded" if not recording.recorded else "no calibration was active")
        for recording in recordings
        if not (recording.recorded and recording.calibration_id)
    ]


def fail_measuring(context: WorkContext, job_id: str, why: str) -> None:
    """End the job and its pass without readings."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state not in {JobState.QUEUED, JobState.RUNNING}:
            return
        row = the(session, Pass, job.subject)
        _step(row, PassState.FAILED)
        row.reason = why
        _keep_axles(context, session, row)
        end(job, JobState.FAILED, at=context.now(), error=why)


def _keep_axles(context: WorkContext, session: Session, row: Pass) -> None:
    try:
        with session.begin_nested():
            keep_axles(session, row, context.settings)
    except Exception as error:  # noqa: BLE001  the readings stand, and the job must end
        why = f"no axles: {one_line(error, row.job_id or row.id)}"
        row.reason = why if row.reason is None else f"{row.reason}; {why}"


def _step(row: Pass, wanted: PassState) -> None:
    PASS.check(row.id, row.state, wanted)
    row.state = wanted
