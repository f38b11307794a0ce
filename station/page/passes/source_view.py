"""The frames that a wheel was measured from: which pictures of which recordings they are."""

from collections.abc import Iterator
from dataclasses import dataclass

from station.errors import StationError
from station.operations import Station, frames_page
from station.recording import ListedFrame
from station.store import Measurement, Pass, Recording, recordings_of, the

_PAGE = 200


@dataclass(frozen=True, slots=True)
class SourceFrame:
    """One sensor's frame of a wheel."""

    recording: str
    sensor: str
    frame: int
    """As the camera numbers it."""
    number: int | None
    """Its place in the recording, from 1; None where it cannot be looked at."""
    why_not: str | None


def source_frames(station: Station, measurement_id: int) -> tuple[SourceFrame, ...]:
    """Return the frame that carried most weight, as each sensor of the wheel saw it.

    Sensors of a rig are triggered together: the frame of one has the same number as the other's.

    Raises
    ------
    NotFound
        If the station knows no such measurement.
    """
    with station.store.look() as session:
        row = the(session, Measurement, measurement_id)
        own = the(session, Recording, row.recording_id)
        sensors = set(row.wheel.get("sensors") or ())
        wanted, frame = [own], row.frame
        if sensors and row.pass_id is not None:
            beside = recordings_of(session, the(session, Pass, row.pass_id))
            wanted += [each for each in beside if each.id != own.id and each.sensor in sensors]
    return tuple(_source(station, each, frame) for each in wanted)


def _source(station: Station, recording: Recording, frame: int) -> SourceFrame:
    try:
        number = next(
            (each.number for each in _frames(station, recording.id) if each.frame_id == frame), None
        )
    except StationError as error:  # deleted to make room, still being written, or damaged
        return SourceFrame(recording.id, recording.sensor, frame, None, str(error))
    return SourceFrame(recording.id, recording.sensor, frame, number, None)


def _frames(station: Station, recording_id: str) -> Iterator[ListedFrame]:
    after, more = 0, True
    while more:
        found, more = frames_page(station, recording_id, after=after, limit=_PAGE)
        yield from found
        after += len(found)
