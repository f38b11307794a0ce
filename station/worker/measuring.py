"""The job that measures a pass: a recording a step, or all of a rig's."""

from collections.abc import Sequence
from typing import NotRequired, TypedDict

from sqlalchemy.orm import Session

from station.documents import CalibrationDocument
from station.limits import limits_of
from station.pipeline import Resumption
from station.settings import StationSettings
from station.store import (
    PASS,
    Calibration,
    Job,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    end,
    recordings_of,
    the,
)
from station.trains import keep_axles
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line
from station.worker.resuming import Measured, measured_with_followed
from station.worker.rows import measurement_row, recorded_on_rig, rows_on_rig, why_silent

_ON_RIG = "rig:"
"""What the name of a rig's step begins with; no recording's id has a colon in it."""


class StepResult(TypedDict):
    """What a step hands on; plain data, as the durable log keeps it."""

    recording: str
    wheels: NotRequired[int]
    refused: NotRequired[str]


def begin_measuring(context: WorkContext, job_id: str) -> list[str]:
    """Take the job up and return the steps of its measuring; none where it has ended.

    A step is a recording by its id, or, for sensors that were recorded on one rig, that rig's
    calibration.
    """
    job = begin(context, job_id)
    if job is None:
        return []
    # From here on the job alone measures the pass; what was certain by now is taken over.
    context.let_go(job.subject)
    with context.store.look() as session:
        recordings = recordings_of(session, the(session, Pass, job.subject))
        measurable = [each for each in recordings if each.recorded and each.calibration_id]
        steps = [
            each.id if each.rig_calibration_id is None else f"{_ON_RIG}{each.rig_calibration_id}"
            for each in measurable
        ]
    return list(dict.fromkeys(steps))


def measure_step(
    context: WorkContext, job_id: str, step: str, *, place: int, of: int
) -> StepResult:
    """Measure the wheels of one step and keep them; a second time adds nothing."""
    progress = JobProgress(context, job_id, first=place / of, last=(place + 1) / of)
    name = step
    try:
        if step.startswith(_ON_RIG):
            on_rig = recorded_on_rig(context, job_id, step.removeprefix(_ON_RIG))
            name = f"rig {on_rig.document.rig}"
            measured = measured_with_followed(
                context,
                on_rig.recordings,
                list(on_rig.measurable.values()),
                lambda since: rows_on_rig(context, on_rig, progress, since),
            )
        else:
            measured = _measured_alone(context, step, progress)
    except JobCancelled:
        return StepResult(recording=name, refused="cancelled")
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        return StepResult(recording=name, refused=one_line(error, job_id))
    with context.store.change() as session:
        if the(session, Job, job_id).state is JobState.RUNNING:
            measured.keep(session)
    return StepResult(recording=name, wheels=len(measured.rows))


def _measured_alone(context: WorkContext, recording_id: str, progress: JobProgress) -> Measured:
    with context.store.look() as session:
        recording = the(session, Recording, recording_id)
        calibration = the(session, Calibration, recording.calibration_id or "")
    document = CalibrationDocument.model_validate_json(calibration.document or "")

    def measure(since: Resumption | None) -> list[Measurement]:
        found = context.mathematics.measure(
            [context.layout.root / recording.path],
            document,
            reference=context.settings.reference,
            limits=limits_of(context.settings.limits),
            progress=progress,
            since=since,
        )
        return [
            measurement_row(context, recording, wheel, place=at, found=found)
            for at, wheel in enumerate(found.wheels)
        ]

    return measured_with_followed(context, [recording], [recording], measure)


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
        single = _measured_singly(context.settings, recordings)
        row.reason = "; ".join([*refused, *_unmeasured(recordings), *single]) or None
        _keep_axles(context, session, row)
        end(job, JobState.DONE, at=context.now())


def _unmeasured(recordings: Sequence[Recording]) -> list[str]:
    return [
        f"{recording.id}: {why_silent(recording)}"
        for recording in recordings
        if not (recording.recorded and recording.calibration_id)
    ]


def _measured_singly(settings: StationSettings, recordings: Sequence[Recording]) -> list[str]:
    """Say which rigs were not measured together: nothing told how their sensors stand."""
    loose = {each.sensor for each in recordings if each.rig_calibration_id is None}
    return [
        f"rig {rig.id}: no calibration was active, its sensors were measured one by one"
        for rig in settings.rigs
        if loose & set(rig.sensors)
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
