"""Taking a frame of a pass by command, where sensors wait for one instead of a wheel switch."""

from collections.abc import Mapping

from station.capture import Trigger
from station.errors import StateConflict
from station.operations.collaborators import Station
from station.processes.threads import at_a_time
from station.settings import SensorSettings
from station.store import Action, Actor, audit, pass_in_progress


def by_command(station: Station) -> list[SensorSettings]:
    """Return the sensors whose frames are taken by command in a pass."""
    return [each for each in station.sensors if Trigger(each.trigger) is Trigger.SOFTWARE]


def trigger_pass(station: Station, *, by: Actor) -> Mapping[str, int]:
    """Expose once by command for the pass in progress; return each sensor's frame id.

    Every sensor that waits for commands exposes, all at one time.

    Raises
    ------
    StateConflict
        If no pass is in progress, none of the sensors is triggered by command, or a trigger is
        under way.
    CameraError
        If no whole frame comes of it.
    """
    sensors = by_command(station)
    if not sensors:
        raise StateConflict(
            'no sensor is triggered by command; set trigger = "software" where one is to be'
        )
    with station.store.change() as session:
        row = pass_in_progress(session)
        if row is None:
            raise StateConflict("no pass is in progress; arm one before you trigger")
        told = {"sensors": [each.id for each in sensors]}
        now = station.now()
        audit(session, Action.CAPTURE, "pass", row.id, by=by, at=now, after=told)
    frames = at_a_time(lambda sensor: station.captures[sensor.id].trigger(), sensors)
    return {sensor.id: frame for sensor, frame in zip(sensors, frames, strict=True)}
