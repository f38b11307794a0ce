"""The sensors the station has, and the refusal of others."""

from station.errors import InputUnusable, NotFound
from station.settings import SensorSettings, StationSettings


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


def _unknown(settings: StationSettings, sensor: str) -> str:
    return f"sensor {sensor!r}: the station has {', '.join(each.id for each in settings.sensors)}"
