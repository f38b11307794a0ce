"""The sensors and rigs the station has, and the refusal of others."""

from station.errors import InputUnusable, NotFound
from station.settings import RigSettings, SensorSettings, StationSettings


def sensor_given(settings: StationSettings, sensor: str) -> SensorSettings:
    """Return the settings of a sensor that a request's body names.

    Raises
    ------
    InputUnusable
        If the station has no such sensor.
    """
    found = settings.sensor(sensor)
    if found is None:
        raise InputUnusable(f"{_unknown(settings, sensor)}; give one of those")
    return found


def sensor_at(settings: StationSettings, sensor: str) -> SensorSettings:
    """Return the settings of a sensor that an address names.

    Raises
    ------
    NotFound
        If the station has no such sensor.
    """
    found = settings.sensor(sensor)
    if found is None:
        raise NotFound(_unknown(settings, sensor))
    return found


def rig_given(settings: StationSettings, rig: str) -> RigSettings:
    """Return the settings of a rig that a request's body names.

    Raises
    ------
    InputUnusable
        If the station has no such rig.
    """
    found = settings.rig(rig)
    if found is None:
        raise InputUnusable(f"{_unknown_rig(settings, rig)}; give one of those")
    return found


def rig_at(settings: StationSettings, rig: str) -> RigSettings:
    """Return the settings of a rig that an address names.

    Raises
    ------
    NotFound
        If the station has no such rig.
    """
    found = settings.rig(rig)
    if found is None:
        raise NotFound(_unknown_rig(settings, rig))
    return found


def _unknown_rig(settings: StationSettings, rig: str) -> str:
    known = ", ".join(each.id for each in settings.rigs) or "none"
    return f"rig {rig!r}: the station has {known}"


def _unknown(settings: StationSettings, sensor: str) -> str:
    return f"sensor {sensor!r}: the station has {', '.join(each.id for each in settings.sensors)}"
