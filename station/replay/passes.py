"""Recordings of several sensors, measured pass for pass, axle for axle."""

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from pathlib import Path

from measure import Side
from station.documents import WheelDocument
from station.pipeline import WheelGauge, on_axles
from station.recording import info

Parts = Sequence[Path]
Measured = Callable[[Mapping[str, Parts], WheelGauge], Iterator[WheelDocument]]
"""Yields the wheels in recordings of one sensor."""


def wheels_of_passes(
    recordings: Mapping[str, Parts],
    gauges: Mapping[str, WheelGauge],
    sides: Mapping[str, Side],
    refused: MutableMapping[str, str],
    measured: Measured,
) -> Iterator[WheelDocument]:
    """Yield the wheels of pass after pass, each with axle and side; those of one are in memory.

    Parameters
    ----------
    recordings
        The files of each, by its name.
    gauges
        By sensor.
    sides
        Of the sensors, where they are known: wheels of the others are put on no axle.
    refused
        Recordings of which nothing is used, and why; is added to, by `measured` as well.
    measured
        How to measure.
    """
    for one_pass in _passes(recordings, gauges, refused):
        seen = {
            sensor: tuple(measured({name: recordings[name]}, gauges[sensor]))
            for sensor, name in one_pass.items()
        }
        sound = {sensor: seen[sensor] for sensor, name in one_pass.items() if name not in refused}
        known = {sensor: own for sensor, own in sound.items() if sensor in sides}
        yield from on_axles(known, sides)
        for sensor, own in sound.items():
            if sensor not in sides:
                yield from own


def _passes(
    recordings: Mapping[str, Parts],
    gauges: Mapping[str, WheelGauge],
    refused: MutableMapping[str, str],
) -> list[dict[str, str]]:
    """Return, of each pass, the name of each sensor's recording."""
    found: dict[str, list[dict[str, str]]] = {}
    for name, parts in recordings.items():
        about = info(parts[0])
        sensors = [one.sensor for one in about.sensors]
        if len(sensors) != 1 or sensors[0] not in gauges:
            refused[name] = (
                f"{name} is of sensor {', '.join(sensors)} but the calibrations are of "
                f"{', '.join(gauges)}; give one calibration of each sensor"
            )
            continue
        (sensor,) = sensors
        named_alike = found.setdefault(about.metadata.get("session", {}).get("id", name), [])
        # A pass has one recording of a sensor: a second is of another pass of that name.
        free = next((one for one in named_alike if sensor not in one), None)
        if free is None:
            named_alike.append({sensor: name})
        else:
            free[sensor] = name
    return [one_pass for passes in found.values() for one_pass in passes]
