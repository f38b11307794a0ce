"""Having the sensors wait for triggers and record: one recording at a time on each."""

from collections.abc import Iterable

from sqlalchemy.orm import Session

from station.capture import RecordingPlan, Trigger
from station.errors import StateConflict
from station.operations.collaborators import Station
from station.settings import SensorSettings
from station.store import (
    Calibration,
    Recording,
    active,
    pass_in_progress,
    session_in_progress,
    the,
)


def ensure_sensors_free(session: Session, sensors: Iterable[SensorSettings], wanted: str) -> None:
    """Let a recording begin only where no other one runs.

    Raises
    ------
    StateConflict
        If a pass or a calibration session holds one of the sensors.
    """
    running = pass_in_progress(session)
    if running is not None:
        raise StateConflict(
            f"{wanted} cannot begin: pass {running.id} is {running.state}; finish it first",
            state=running.state,
        )
    for sensor in sensors:
        held = session_in_progress(session, sensor.id)
        if held is not None:
            raise StateConflict(
                f"{wanted} cannot begin: calibration session {held.id} on sensor {sensor.id} "
                f"is {held.state}; finish it first",
                state=held.state,
            )


def calibration_in_force(session: Session, sensor: str) -> str | None:
    """Return the id of the calibration in force on a sensor, or None."""
    activation = active(session, sensor)
    return None if activation is None else activation.calibration_id


def arm(station: Station, recording: Recording, *, owner: str, trigger: Trigger) -> None:
    """Have the capture process of a recording's sensor wait for triggers and record.

    Raises
    ------
    CameraError, RecordingError
        If the camera or the disk does not let it.
    """
    path = station.layout.root / recording.path
    path.parent.mkdir(parents=True, exist_ok=True)
    station.captures[recording.sensor].arm(
        RecordingPlan(
            session_id=owner,
            path=path,
            sensor=recording.sensor,
            trigger=trigger,
            metadata={"station": station.settings.name, "recording": recording.id},
            attachments=_attachments(station, recording),
        )
    )


def _attachments(station: Station, recording: Recording) -> dict[str, bytes]:
    if recording.calibration_id is None:
        return {}
    with station.store.look() as session:
        document = the(session, Calibration, recording.calibration_id).document
    return {"calibration.json": (document or "").encode()}
