"""Troubles that the store knows of: calibrations, the last pass, what waits."""

from collections.abc import Iterator
from datetime import datetime, timedelta

from sqlalchemy.orm import Session

from station.settings import SensorSettings, StationSettings
from station.store import (
    EndedBy,
    Pass,
    PassState,
    RecalibrationState,
    Recording,
    active,
    active_rig,
)
from station.store.recalibrations import alarm_of, asking_recalibrations
from station.store.watched import last_pass_recording, last_recalibration, queued_jobs
from station.watching.troubles import (
    CONTROLLER,
    WORKER,
    Trouble,
    TroubleKind,
    part_of_rig,
    part_of_sensor,
)

_LATE = timedelta(minutes=10)


def store_troubles(
    session: Session, settings: StationSettings, now: datetime, since_start: datetime
) -> Iterator[Trouble]:
    """Yield what the store knows.

    Parameters
    ----------
    since_start
        When this process began to look; the moment of what has none of its own.
    """
    ended: dict[str, Pass] = {}
    for sensor in settings.sensors:
        yield from _of_calibration(session, sensor, since_start)
        last = last_pass_recording(session, sensor.id)
        if last is not None:
            recording, of_pass = last
            ended[of_pass.id] = of_pass
            yield from _of_recording(recording, of_pass)
    for rig in settings.rigs:
        if active_rig(session, rig.id) is None:
            what = "no calibration is in force: its sensors are measured one by one"
            yield Trouble(TroubleKind.CALIBRATION_MISSING, part_of_rig(rig.id), what, since_start)
    yield from _of_ends(ended)
    yield from _of_queue(session, now)


def _of_calibration(
    session: Session, sensor: SensorSettings, since_start: datetime
) -> Iterator[Trouble]:
    part = part_of_sensor(sensor.id)
    if active(session, sensor.id) is None:
        what = "no calibration is in force: its passes are recorded and not measured"
        yield Trouble(TroubleKind.CALIBRATION_MISSING, part, what, since_start)
    found = alarm_of(session, sensor.id)
    if found is not None:
        why = "; ".join((found.reasons or {}).get("reasons", []))
        what = f"recalibration {found.id}: {why}"
        yield Trouble(
            TroubleKind.CALIBRATION_DOUBTFUL, part, what, found.ended_at or found.ordered_at
        )
    for asking in asking_recalibrations(session, sensor.id):
        what = f"recalibration {asking.id} waits for an answer"
        yield Trouble(
            TroubleKind.RECALIBRATION_ASKS, part, what, asking.ended_at or asking.ordered_at
        )
    last = last_recalibration(session, sensor.id)
    if last is not None and last.state is RecalibrationState.FAILED:
        what = f"recalibration {last.id}: {last.reason}"
        yield Trouble(
            TroubleKind.RECALIBRATION_FAILED, part, what, last.ended_at or last.ordered_at
        )


def _of_recording(recording: Recording, of_pass: Pass) -> Iterator[Trouble]:
    part, since = part_of_sensor(recording.sensor), recording.closed_at or recording.opened_at
    missing = (recording.lost or 0) + (recording.refused or 0)
    if missing:
        what = f"pass {of_pass.id}: {missing} frames lost; {recording.summary}"
        yield Trouble(TroubleKind.FRAMES_LOST, part, what, since)
    if of_pass.state is PassState.FAILED:
        what = f"pass {of_pass.id} failed: {of_pass.reason}"
        yield Trouble(TroubleKind.PASS_FAILED, part, what, since)


def _of_ends(ended: dict[str, Pass]) -> Iterator[Trouble]:
    """Yield it where the controller did not end the last pass itself."""
    if not ended:
        return
    last = max(ended.values(), key=lambda each: each.opened_at)
    if last.ended_by is EndedBy.TIMEOUT:
        what = f"pass {last.id}: {last.ended_why}"
        yield Trouble(
            TroubleKind.CONTROLLER_SILENT, CONTROLLER, what, last.finished_at or last.opened_at
        )


def _of_queue(session: Session, now: datetime) -> Iterator[Trouble]:
    for kind, (count, oldest) in queued_jobs(session).items():
        if now - oldest > _LATE:
            minutes = (now - oldest).total_seconds() / 60.0
            what = f"{count} jobs of kind {kind} wait, the oldest for {minutes:.0f} min"
            yield Trouble(TroubleKind.JOB_LATE, WORKER, what, oldest)
