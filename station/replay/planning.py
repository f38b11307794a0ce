"""From sources to tasks: a recording each, or a pass."""

import tempfile
from collections.abc import Mapping, MutableMapping, Sequence
from pathlib import Path

from station.errors import StationError
from station.recording import info
from station.replay.finding import find_addresses, whole_recordings_at
from station.replay.means import Means
from station.replay.remote import fetched
from station.replay.task import RecordingFiles, ReplayTask


def planned(
    sources: Sequence[str | Path],
    means: Means,
    refused: MutableMapping[str, str],
    *,
    by_address: bool,
) -> list[ReplayTask]:
    """Return what is to be measured, in the order of the table.

    Parameters
    ----------
    sources
        Files, folders, URLs.
    means
        What to measure with.
    refused
        Is told of recordings that cannot be used, and why.
    by_address
        As of `whole_recordings_at`.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or is given twice.
    """
    recordings = whole_recordings_at(find_addresses(sources), refused, by_address=by_address)
    if not means.by_pass:
        return [ReplayTask((one,)) for one in recordings]
    passes = _passes(recordings, means.sensors, refused)
    return [ReplayTask(tuple(own.values()), tuple(own)) for own in passes]


def _passes(
    recordings: Sequence[RecordingFiles], known: Sequence[str], refused: MutableMapping[str, str]
) -> list[Mapping[str, RecordingFiles]]:
    """Return, of each pass, each sensor's recording."""
    found: dict[str, list[dict[str, RecordingFiles]]] = {}
    for recording in recordings:
        try:
            sensors, session = _sensors_and_session(recording)
        except StationError as error:
            refused[recording.name] = str(error)
            continue
        if len(sensors) != 1 or sensors[0] not in known:
            refused[recording.name] = (
                f"{recording.name} is of sensor {', '.join(sensors)} but the calibrations are of "
                f"{', '.join(known)}; give one calibration of each sensor"
            )
            continue
        (sensor,) = sensors
        named_alike = found.setdefault(session, [])
        # A pass has one recording of a sensor: a second is of another pass of that name.
        free = next((one for one in named_alike if sensor not in one), None)
        if free is None:
            named_alike.append({sensor: recording})
        else:
            free[sensor] = recording
    return [one_pass for passes in found.values() for one_pass in passes]


def _sensors_and_session(recording: RecordingFiles) -> tuple[list[str], str]:
    with tempfile.TemporaryDirectory(prefix="treadline-plan-") as folder:
        about = info(fetched(recording.addresses[:1], Path(folder))[0])
    sensors = [one.sensor for one in about.sensors]
    return sensors, about.metadata.get("session", {}).get("id", recording.name)
