"""What a controller tells of a train that has gone: once, by its finish or any time later."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from station.errors import StateConflict
from station.operations.closing import recount
from station.operations.repeats import ensure_consist
from station.store import Pass, Recording
from station.trains import Consist


@dataclass(frozen=True, slots=True)
class Counted:
    """What the controller counted and named; None and empty where it did not.

    Attributes
    ----------
    axles
        Wheels that went by every sensor.
    triggers
        Triggers given to single sensors, where they differ from `axles`.
    consist
        The train's wheelsets, where they were not named when it came.
    """

    axles: int | None = None
    triggers: Mapping[str, int] = field(default_factory=dict)
    consist: Consist | None = None

    def triggers_of(self, sensor: str) -> int | None:
        """Return the triggers that a sensor was given."""
        return self.triggers.get(sensor, self.axles)


def take_counts(row: Pass, recordings: Sequence[Recording], told: Counted) -> bool:
    """Write what was told into the rows of a pass; return whether any of it is new.

    Of a recording that is closed the frames are held against the triggers once more.

    Raises
    ------
    StateConflict
        If something else was told before.
    """
    ensure_consist(row, told.consist)
    for what, present, now in _pairs(row, recordings, told):
        if present is not None and now is not None and present != now:
            raise StateConflict(
                f"pass {row.id} was finished with {present} {what}, not with {now}; what was "
                "counted is told once",
                state=row.state,
            )
    named, counted = _take_consist(row, told.consist), _take_axles(row, told.axles)
    held = [_take_triggers(each, told.triggers_of(each.sensor)) for each in recordings]
    return named or counted or any(held)


def _pairs(
    row: Pass, recordings: Sequence[Recording], told: Counted
) -> Iterator[tuple[str, int | None, int | None]]:
    yield "axles", row.axles, told.axles
    for each in recordings:
        yield f"triggers of sensor {each.sensor}", each.expected, told.triggers_of(each.sensor)


def _take_consist(row: Pass, consist: Consist | None) -> bool:
    if consist is None or row.consist is not None:
        return False
    row.consist = consist.to_json()
    return True


def _take_axles(row: Pass, axles: int | None) -> bool:
    if axles is None or row.axles is not None:
        return False
    row.axles = axles
    return True


def _take_triggers(recording: Recording, triggers: int | None) -> bool:
    if triggers is None or recording.expected is not None:
        return False
    if recording.closed_at is None:
        recording.expected = triggers
    else:
        recount(recording, triggers)
    return True
