"""The station and its sensors."""

import shutil
from functools import partial

from fastapi import APIRouter
from sqlalchemy.orm import Session

from station.api.callers import Reader
from station.api.health_answers import StationAlarmModel
from station.api.parts import PartsOf
from station.api.remembered import for_a_moment
from station.api.station_answers import RigModel, SensorModel, StationModel
from station.errors import StationError
from station.operations import Station
from station.processes.threads import at_a_time
from station.settings import RigSettings, SensorSettings, StationSettings
from station.software import SOFTWARE
from station.store import active, active_rig, pass_in_progress
from station.store.recalibrations import alarm_of, asking_recalibrations

router = APIRouter(prefix="/v1", tags=["station"])


@router.get("/station")
@for_a_moment
def get_station(parts: PartsOf, _: Reader) -> StationModel:
    """Return the sensors, their states and rigs, the version, the disk, and what is wrong."""
    station = parts.station
    disk = shutil.disk_usage(station.layout.root)
    told = at_a_time(partial(_told_by_capture, station), station.sensors)
    with station.store.look() as session:
        running = pass_in_progress(session)
        pairs = zip(station.sensors, told, strict=True)
        sensors = [_sensor(session, sensor, *of_sensor) for sensor, of_sensor in pairs]
        rigs = [_rig(session, station.settings, rig) for rig in station.settings.rigs]
    return StationModel(
        name=station.settings.name,
        software=SOFTWARE,
        reference=station.settings.reference,
        sensors=sensors,
        rigs=rigs,
        pass_in_progress=running.id if running else None,
        worker_ready=parts.worker_ready(),
        disk_free_bytes=disk.free,
        disk_total_bytes=disk.total,
        alarms=[StationAlarmModel.of(trouble) for trouble in parts.lookout.look().troubles],
    )


def _told_by_capture(station: Station, sensor: SensorSettings) -> tuple[str, str | None]:
    """Return the state of a sensor's capture process, and what is the matter with it."""
    try:
        status = station.captures[sensor.id].status()
    except StationError as error:
        return "unreachable", str(error)
    return str(status.state), status.problem


def _rig(session: Session, settings: StationSettings, rig: RigSettings) -> RigModel:
    activation = active_rig(session, rig.id)
    return RigModel(
        id=rig.id,
        side=settings.side_of(rig),
        sensors=list(rig.sensors),
        anchor=settings.anchor_of(rig),
        active_calibration=activation.rig_calibration_id if activation else None,
    )


def _sensor(
    session: Session, sensor: SensorSettings, state: str, problem: str | None
) -> SensorModel:
    activation = active(session, sensor.id)
    alarm = alarm_of(session, sensor.id)
    asking = asking_recalibrations(session, sensor.id)
    return SensorModel(
        id=sensor.id,
        side=sensor.side,
        address=sensor.address,
        state=state,
        problem=problem,
        active_calibration=activation.calibration_id if activation else None,
        alarm="; ".join((alarm.reasons or {}).get("reasons", [])) if alarm else None,
        asks=asking[0].id if asking else None,
    )
