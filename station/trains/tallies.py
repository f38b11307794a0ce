"""How many alarms a train raised, for lists of many trains."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

from sqlalchemy.orm import Session

from measure import Alarm, Side
from station.store.measured import WheelLevels, wheel_levels


@dataclass(frozen=True, slots=True)
class AlarmTally:
    """What a train raised, counted as `train_picture` lists it, and what was seen of it."""

    alarms: int = 0
    warnings: int = 0
    wheels: int = 0
    """Both wheels of every axle."""
    measured: int = 0


def alarm_tallies(session: Session, passes: Collection[str]) -> Mapping[str, AlarmTally]:
    """Return the tally of each pass whose axles are kept."""
    found: dict[str, AlarmTally] = {}
    for wheel in wheel_levels(session, passes):
        tally = found.get(wheel.pass_id, AlarmTally())
        levels = list(_levels(wheel))
        found[wheel.pass_id] = replace(
            tally,
            alarms=tally.alarms + levels.count(Alarm.ALARM),
            warnings=tally.warnings + levels.count(Alarm.WARNING),
            wheels=tally.wheels + 1,
            measured=tally.measured + wheel.measured,
        )
    return found


def _levels(wheel: WheelLevels) -> Iterator[str]:
    yield from wheel.levels
    yield from (Alarm.ALARM for _ in wheel.jumps)
    # Both wheels of an axle hold the distance; it is one.
    if wheel.side is Side.LEFT and wheel.back_to_back is not None:
        yield wheel.back_to_back["alarm"]
