"""The job that measures recordings once more: a recording a step, or those of a rig together.

Each step keeps what it measured and what it says of it in one transaction, so that a worker killed
in between does no step twice and loses none.
"""

from collections.abc import Sequence
from dataclasses import replace

from station.documents import CalibrationDocument, RigDocument
from station.limits import limits_of
from station.store import (
    JOB,
    Calibration,
    Job,
    JobState,
    JsonObject,
    Measurement,
    Recording,
    Replay,
    RigCalibration,
    end,
    the,
)
from station.store.measured import add_measurements, note_measured
from station.worker.context import WorkContext
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line
from station.worker.rows import RecordedOnRig, measurement_row, rows_on_rig


def begin_replay(context: WorkContext, job_id: str) -> int:
    """Take the job up and return how many steps it has; none where it has ended."""
    job = begin(context, job_id)
    if job is None:
        return 0
    with context.store.look() as session:
        return len(the(session, Replay, job.subject).steps["steps"])


def replay_step(context: WorkContext, job_id: str, place: int) -> None:
    """Measure what one step names and keep it; a second time adds nothing."""
    with context.store.look() as session:
        row = the(session, Replay, the(session, Job, job_id).subject)
    names = row.steps["steps"][place]
    of = len(row.steps["steps"])
    progress = JobProgress(context, job_id, first=place / of, last=(place + 1) / of)
    try:
        measured = _measured(context, row, names, progress)
    except JobCancelled:
        return
    except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
        _keep(context, row, names, [], refused=one_line(error, job_id))
        return
    _keep(context, row, names, measured)


def _measured(
    context: WorkContext, row: Replay, names: Sequence[str], progress: JobProgress
) -> list[Measurement]:
    against = context.settings.model_copy(update={"reference": row.reference})
    with context.store.look() as session:
        recordings = [_as_if(the(session, Recording, name), row) for name in names]
        calibrations = [
            CalibrationDocument.model_validate_json(
                the(session, Calibration, row.calibrations[each.sensor]).document or ""
            )
            for each in recordings
        ]
        rig = row.rig_calibration_id
        document = None if rig is None else the(session, RigCalibration, rig).document
    if document is not None:
        on_rig = RecordedOnRig(
            RigDocument.model_validate_json(document), tuple(recordings), tuple(calibrations)
        )
        return rows_on_rig(replace(context, settings=against), on_rig, progress)
    (recording,), (calibration,) = recordings, calibrations
    found = context.mathematics.measure(
        [context.layout.root / recording.path],
        calibration,
        reference=against.reference,
        limits=limits_of(against.limits),
        progress=progress,
    )
    return [
        measurement_row(context, recording, wheel, place=at, found=found)
        for at, wheel in enumerate(found.wheels)
    ]


def _as_if(recording: Recording, row: Replay) -> Recording:
    """Return a recording as if it had been made under the calibrations of a replay.

    It is no row of the store: what the station recorded, it recorded under others.
    """
    return Recording(
        id=recording.id,
        sensor=recording.sensor,
        pass_id=recording.pass_id,
        path=recording.path,
        recorded=recording.recorded,
        calibration_id=row.calibrations[recording.sensor],
        rig_calibration_id=row.rig_calibration_id,
    )


def _keep(
    context: WorkContext,
    row: Replay,
    names: Sequence[str],
    measured: Sequence[Measurement],
    *,
    refused: str | None = None,
) -> None:
    with context.store.change() as session:
        if the(session, Job, row.job_id).state is not JobState.RUNNING:
            return
        replay = the(session, Replay, row.id)
        if names[0] in replay.results:
            return  # done before the worker was killed, which did not live to say so
        said: JsonObject = {"refused": refused}
        if refused is None:
            added = add_measurements(session, measured)
            note_measured(session, row.id, measured)
            said = {"wheels": len(measured), "added": added}
        replay.results = {**replay.results, names[0]: said}


def conclude_replay(context: WorkContext, job_id: str) -> None:
    """End the job: failed where nothing could be measured; passes stay as they are."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is not JobState.RUNNING:
            return
        results = the(session, Replay, job.subject).results
        refused = [
            f"{name}: {said['refused']}" for name, said in results.items() if "refused" in said
        ]
        failed = len(refused) == len(results)
        state = JobState.FAILED if failed else JobState.DONE
        why = "; ".join(refused) or ("there was nothing to measure" if failed else None)
        end(job, state, at=context.now(), error=why)


def fail_replay(context: WorkContext, job_id: str, why: str) -> None:
    """End the job; what it measured stays."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if not JOB.ended(job.state):
            end(job, JobState.FAILED, at=context.now(), error=why)
