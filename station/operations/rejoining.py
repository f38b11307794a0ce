"""A sensor whose capture process died in the middle of a pass, and is there again, goes on with it.

What the dead process left is made whole and stays as it is; the sensor is armed into the next file
of the same recording, which begins with an event that says how long nobody was there.
"""

from collections.abc import Iterable, Mapping

import structlog

from station.capture import CaptureState, CaptureStatus, Interruption, Trigger
from station.errors import RecordingError, StationError
from station.log_ids import about
from station.operations.arming import arm
from station.operations.collaborators import Salvaged, Station
from station.operations.sensors import sensor_given
from station.store import STATION, Action, Recording, audit

_MOST_TRIES = 3
"""In one pass, well or not: what dies again and again is looked after by a person."""
_log = structlog.get_logger()


class Rejoining:
    """Arms the sensors of a pass again that stand idle beside it."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._tries: dict[str, int] = {}
        """By recording, since this process began; what the files tell is older."""

    def rejoin(
        self, recordings: Iterable[Recording], statuses: Mapping[str, CaptureStatus | None]
    ) -> None:
        """Arm those sensors again that have a camera and record nothing.

        Only for a pass that goes on, and while nobody can end it.  Never raises for what happened
        to camera, process or file: the pass goes on without the sensor, and says so.
        """
        for recording in recordings:
            if recording.closed_at is None and is_idle(statuses.get(recording.sensor)):
                with about(recording=recording.id, sensor=recording.sensor):
                    self._try(recording)

    def _try(self, recording: Recording) -> None:
        tries = self._tries.get(recording.id, 0)
        if tries > _MOST_TRIES:
            return  # left out, which was said
        self._tries[recording.id] = tries + 1
        try:
            found = self._station.salvage(self._station.layout.root / recording.path)
            tries = max(tries, 0 if found is None else found.interruptions)
            self._tries[recording.id] = tries + 1
            if tries < _MOST_TRIES:
                self._arm(recording, interruption_of(recording, found))
            else:
                _log.error("sensor left out of the pass", why=f"armed again {tries} times before")
        except StationError as error:
            _log.warning("sensor not armed again", why=str(error))

    def _arm(self, recording: Recording, before: Interruption) -> None:
        station = self._station
        sensor = sensor_given(station.settings, recording.sensor)
        owner = recording.pass_id or ""
        arm(station, recording, owner=owner, trigger=Trigger(sensor.trigger), before=before)
        told = {"sensor": sensor.id, "file": before.files + 1, "behind_frame": before.last_frame_id}
        with station.store.change() as session:
            at = station.now()
            audit(session, Action.ARM, "pass", owner, by=STATION, at=at, after=told)
        _log.warning("sensor armed again", pass_id=owner, frames=before.frames)


def is_idle(status: CaptureStatus | None) -> bool:
    """Tell whether a capture process has its camera and records nothing."""
    return status is not None and status.state is CaptureState.IDLE and status.session_id is None


def interruption_of(recording: Recording, found: Salvaged | None) -> Interruption:
    """Return where a recording is gone on with.

    Raises
    ------
    RecordingError
        If it has frames and the last one's number cannot be read.
    """
    began_ns = round(recording.opened_at.timestamp() * 1e9)
    if found is None or not found.frames:
        return Interruption(0 if found is None else found.files, 0, 0, began_ns)
    if found.last_frame_id is None or found.last_frame_ns is None:
        raise RecordingError(
            f"the last of {found.frames} frames of {recording.path} cannot be read; look at it "
            "with `station recording verify`"
        )
    return Interruption(found.files, found.frames, found.last_frame_id, found.last_frame_ns)
