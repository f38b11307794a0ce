"""Which source is of which sensor of a rig."""

from collections.abc import Sequence
from pathlib import Path

from station.errors import InputUnusable
from station.pipeline.frames import files_by_source, is_recording
from station.pipeline.naming import distinct_names
from station.recording import info


def sources_by_sensor(
    sources: Sequence[Path], sensors: Sequence[str], *, all_wanted: bool = True
) -> dict[str, Path]:
    """Return the source of each sensor: recordings by what they say, others in the order given.

    Parameters
    ----------
    sources
        One a sensor; of a recording of several files the first counts.
    sensors
        In the order in which pictures and folders are given.
    all_wanted
        Whether a sensor without a source is refused.

    Raises
    ------
    InputUnusable
        If a source cannot be used or is given twice, two are of one sensor, or one is of none.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable(f"no SOURCE given; give one of each of {', '.join(sensors)}")
    distinct_names(sources)
    recordings = [source for source in sources if is_recording(source)]
    found: dict[str, Path] = {}
    for files in files_by_source(recordings):
        if files:  # else it is a later file of another source
            _add(found, _sensor_of(files[0], sensors), files[0])
    for source in sources:
        if not is_recording(source):
            free = next((name for name in sensors if name not in found), None)
            if free is None:
                raise InputUnusable(
                    f"{source}: one source too many; give one of each of {', '.join(sensors)}"
                )
            found[free] = source
    missing = [name for name in sensors if name not in found]
    if missing and all_wanted:
        raise InputUnusable(
            f"no SOURCE of sensor {missing[0]}; give one of each of {', '.join(sensors)}"
        )
    return {name: found[name] for name in sensors if name in found}


def _sensor_of(recording: Path, sensors: Sequence[str]) -> str:
    named = [one.sensor for one in info(recording).sensors]
    if len(named) != 1 or named[0] not in sensors:
        raise InputUnusable(
            f"{recording} is of sensor {', '.join(named) or 'none'}; "
            f"allowed: one of {', '.join(sensors)}"
        )
    return named[0]


def _add(found: dict[str, Path], sensor: str, source: Path) -> None:
    if sensor in found:
        raise InputUnusable(
            f"{found[sensor]} and {source} are both of sensor {sensor}; give one of each sensor"
        )
    found[sensor] = source
