"""Having the sensors wait for triggers and record: one recording at a time on each."""

from collections.abc import Iterable

from sqlalchemy.orm import Session

from station.capture import ExposureStep, Interruption, RecordingPlan, Trigger
from station.errors import StateConflict, StationError
from station.operations.collaborators import Station
from station.operations.strays import close_strays
from station.recording import Rotation
from station.settings import SensorSettings, StationSettings, StorageSettings
from station.storage import Expected, ensure_space, expected_of_pass, expected_of_session
from station.store import (
    Calibration,
    Recording,
    RigCalibration,
    active,
    active_rig,
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


def ensure_space_for_pass(station: Station) -> None:
    """Let a pass begin only where its longest fits on the disk.

    Raises
    ------
    DiskFull
        If it does not.
    """
    storage = station.settings.storage
    expected = [
        expected_of_pass(sensor, storage, _picture_bytes(station, sensor))
        for sensor in station.sensors
    ]
    _ensure_space(station, expected, "the longest pass")


def ensure_space_for_session(station: Station, sensors: Iterable[SensorSettings]) -> None:
    """Let a calibration session begin only where its pictures fit on the disk.

    Raises
    ------
    DiskFull
        If they do not.
    """
    expected = [
        expected_of_session(sensor, station.settings.storage, _picture_bytes(station, sensor))
        for sensor in sensors
    ]
    _ensure_space(station, expected, "a calibration session")


def _ensure_space(station: Station, expected: Iterable[Expected], wanted: str) -> None:
    storage = station.settings.storage
    keep_free_gb = max(storage.keep_free_gb, storage.reserve_mb / 1e3)
    ensure_space(station.layout.root, expected, keep_free_gb, wanted)


def _picture_bytes(station: Station, sensor: SensorSettings) -> int | None:
    """Return the size of a sensor's pictures as its camera says it, or None where it does not."""
    try:
        camera = station.captures[sensor.id].status().camera
        return int(camera["width"]) * int(camera["height"])
    except (KeyError, ValueError, StationError):
        return None


def calibration_in_force(session: Session, sensor: str) -> str | None:
    """Return the id of the calibration in force on a sensor, or None."""
    activation = active(session, sensor)
    return None if activation is None else activation.calibration_id


def rig_in_force(session: Session, settings: StationSettings, sensor: str) -> str | None:
    """Return the id of the calibration in force on the rig that a sensor is in, or None."""
    rig = settings.rig_with(sensor)
    activation = None if rig is None else active_rig(session, rig.id)
    return None if activation is None else activation.rig_calibration_id


def arm(
    station: Station,
    recording: Recording,
    *,
    owner: str,
    trigger: Trigger,
    before: Interruption | None = None,
) -> None:
    """Have the capture process of a recording's sensor wait for triggers and record.

    Where there is something of the recording from `before`, it goes on behind that.

    Raises
    ------
    CameraError, RecordingError
        If the camera or the disk does not let it.
    """
    path = station.layout.root / recording.path
    path.parent.mkdir(parents=True, exist_ok=True)
    plan = RecordingPlan(
        session_id=owner,
        path=path,
        sensor=recording.sensor,
        trigger=trigger,
        sequence=_sequence(station.settings.sensor(recording.sensor), trigger),
        rotation=_rotation(station.settings.storage, trigger),
        reserve_bytes=round(station.settings.storage.reserve_mb * 1e6),
        metadata=_metadata(station, recording),
        attachments=_attachments(station, recording),
        goes_on=before,
        looks=recording.session_id is not None and trigger is Trigger.SOFTWARE,
    )
    capture = station.captures[recording.sensor]
    try:
        capture.arm(plan)
    except StateConflict:
        # The store has no other recording open on this sensor: what it still records was closed
        # while it did not answer, and must not cost the next train.
        close_strays(station, {recording.sensor: capture.status()})
        capture.arm(plan)


def _metadata(station: Station, recording: Recording) -> dict[str, str]:
    names = {"station": station.settings.name, "recording": recording.id}
    return names if recording.pass_id is None else {**names, "pass": recording.pass_id}


def _sequence(sensor: SensorSettings | None, trigger: Trigger) -> tuple[ExposureStep, ...]:
    """Return what a command takes of each pose: the sensor's exposures for calibrations."""
    if sensor is None or trigger is not Trigger.SOFTWARE:
        return ()
    return tuple(
        ExposureStep(
            one.exposure_us, sensor.gain_db if one.gain_db is None else one.gain_db, one.laser
        )
        for one in sensor.calibration_exposures
    )


def _rotation(storage: StorageSettings, trigger: Trigger) -> Rotation:
    """Return when a recording goes on in a next file; pictures taken one by one need no hurry."""
    seconds = None if trigger is Trigger.SOFTWARE else storage.rotate_s
    size_bytes = None if storage.rotate_mb is None else round(storage.rotate_mb * 1e6)
    return Rotation(seconds, size_bytes)


def _attachments(station: Station, recording: Recording) -> dict[str, bytes]:
    documents: dict[str, str | None] = {}
    with station.store.look() as session:
        if recording.calibration_id is not None:
            own = the(session, Calibration, recording.calibration_id)
            documents["calibration.json"] = own.document
        if recording.rig_calibration_id is not None:
            rig = the(session, RigCalibration, recording.rig_calibration_id)
            documents["rig.json"] = rig.document
    return {name: (document or "").encode() for name, document in documents.items()}
