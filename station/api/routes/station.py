"""The station and its sensors."""

import shutil

from fastapi import APIRouter

from station.api.callers import Reader
from station.api.health_answers import StationAlarmModel
from station.api.parts import PartsOf
from station.api.remembered import for_a_moment
from station.api.station_answers import RigModel, SensorModel, StationModel
from station.errors import StationError
from station.operations import Station
from station.settings import RigSettings, SensorSettings
from station.software import SOFTWARE
from station.store import (
    active,
    active_rig,
    alarm_of,
    asking_recalibrations,
    pass_in_progress,
)

router = APIRouter(prefix="/v1", tags=["station"])


@router.get("/station")
@for_a_moment
def get_station(parts: PartsOf, _: Reader) -> StationModel:
    """Return the sensors, their states and rigs, the version, the disk, and what is wrong."""
    station = parts.station
    disk = shutil.disk_usage(station.layout.root)
    with station.store.look() as session:
        running = pass_in_progress(session)
    return StationModel(
        name=station.settings.name,
        software=SOFTWARE,
        reference=station.settings.reference,
        sensors=[_sensor(station, sensor) for sensor in station.sensors],
        rigs=[_rig(station, rig) for rig in station.settings.rigs],
        pass_in_progress=running.id if running else None,
        worker_ready=parts.worker_ready(),
        disk_free_bytes=disk.free,
        disk_total_bytes=disk.total,
        alarms=[StationAlarmModel.of(trouble) for trouble in parts.lookout.look().troubles],
    )


def _rig(station: Station, rig: RigSettings) -> RigModel:
    with station.store.look() as session:
        activation = active_rig(session, rig.id)
    return RigModel(
        id=rig.id,
        side=station.settings.side_of(rig),
        sensors=list(rig.sensors),
        anchor=station.settings.anchor_of(rig),
        active_calibration=activation.rig_calibration_id if activation else None,
    )


def _sensor(station: Station, sensor: SensorSettings) -> SensorModel:
    try:
        status = station.captures[sensor.id].status()
        state, problem = str(status.state), status.problem
    except StationError as error:
        state, problem = "unreachable", str(error)
    with station.store.look() as session:
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
