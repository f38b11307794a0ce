"""One placing of a rigid target, and the pictures that the cameras of a rig took of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from calib.sensor import LaserSensor
from calib.target import Target
from calib.views import View


@dataclass(frozen=True, slots=True, eq=False)
class RigShowing:
    """What the cameras saw while the target stood still.

    Attributes
    ----------
    name
        Of the showing.
    views
        Of each sensor that saw it: which of the target's boards, and what was seen.
    """

    name: str
    views: Mapping[str, tuple[str, View]]


def check_names(
    showings: Sequence[RigShowing],
    sensors: Mapping[str, LaserSensor],
    boards: Mapping[str, Target],
    anchor: str,
) -> None:
    """Refuse showings that speak of what is not there.

    Raises
    ------
    ValueError
        If the anchor, a sensor or a board is unknown, or two showings share a name.
    """
    if anchor not in sensors:
        raise ValueError(f"the anchor {anchor!r} is none of the sensors {sorted(sensors)}")
    names = [showing.name for showing in showings]
    if len(set(names)) < len(names):
        raise ValueError(f"showings must have a name each, got {names}")
    for showing in showings:
        for sensor, (board, _) in showing.views.items():
            if sensor not in sensors:
                raise ValueError(
                    f"showing {showing.name!r} is of a sensor {sensor!r}; "
                    f"sensors are {sorted(sensors)}"
                )
            if board not in boards:
                raise ValueError(
                    f"showing {showing.name!r} is of a board {board!r}; boards are {sorted(boards)}"
                )
