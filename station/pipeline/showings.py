"""Showings of a rigid target: which pictures of several sensors show it standing in one place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import PurePath

from calib import StripePoints, View
from station.errors import InputUnusable

LONGEST_S = 2.0
"""Pictures of one showing are taken one after the other while nobody touches the target."""


@dataclass(frozen=True, slots=True)
class SeenPose:
    """One pose of the target, or of the piece, as one sensor saw it, or why it did not.

    Attributes
    ----------
    name
        Of the picture.
    seen
        The view, or the stripe on the piece, or the reason.
    time_ns
        When the picture was taken; None where nothing tells it.
    """

    name: str
    seen: View | StripePoints | str
    time_ns: int | None = None

    @property
    def key(self) -> str:
        """The picture's name without folder and kind: pictures of one showing often share it."""
        return PurePath(self.name).stem


Showing = Mapping[str, SeenPose]
"""The pictures of one showing, by sensor."""


def showings_of(poses: Mapping[str, Sequence[SeenPose]]) -> list[tuple[str, Showing]]:
    """Return the showings with a name each: by time, else by the pictures' names, else by order.

    Parameters
    ----------
    poses
        Of each sensor, in the order they were taken.

    Raises
    ------
    InputUnusable
        If neither times nor names tell which pictures belong together, and their numbers differ.
    """
    every = [pose for own in poses.values() for pose in own]
    if every and all(pose.time_ns is not None for pose in every):
        return _numbered(_by_time(poses))
    keys = [{pose.key for pose in own} for own in poses.values()]
    alone = [len(own) == len(key) for own, key in zip(poses.values(), keys, strict=True)]
    if all(alone) and 2 * len(set.intersection(*keys)) >= min(map(len, keys)) > 0:
        return _by_name(poses)
    counts = {sensor: len(own) for sensor, own in poses.items()}
    if len(set(counts.values())) > 1:
        told = ", ".join(f"{sensor} {count}" for sensor, count in counts.items())
        raise InputUnusable(
            f"pictures pair by order but there are of {told}; give one of each showing, or name "
            "pictures of one showing alike"
        )
    rows = zip(*poses.values(), strict=True)
    return _numbered([dict(zip(poses, row, strict=True)) for row in rows])


def missing_in(showings: Sequence[tuple[str, Showing]], sensors: Sequence[str]) -> dict[str, str]:
    """Return which showings have no picture of a sensor, and say so."""
    return {
        f"{name} {sensor}": f"no picture of {sensor}"
        for name, showing in showings
        for sensor in sensors
        if sensor not in showing
    }


def _by_time(poses: Mapping[str, Sequence[SeenPose]]) -> list[Showing]:
    """Begin a showing where a sensor comes again, or the pictures before are long past."""
    taken = [(pose.time_ns or 0, sensor, pose) for sensor, own in poses.items() for pose in own]
    showings: list[dict[str, SeenPose]] = []
    before_ns = 0
    for time_ns, sensor, pose in sorted(taken, key=itemgetter(0)):
        late = time_ns - before_ns > LONGEST_S * 1e9
        if not showings or late or sensor in showings[-1]:
            showings.append({})
        showings[-1][sensor] = pose
        before_ns = time_ns
    return list(showings)


def _by_name(poses: Mapping[str, Sequence[SeenPose]]) -> list[tuple[str, Showing]]:
    showings: dict[str, dict[str, SeenPose]] = {}
    for sensor, own in poses.items():
        for pose in own:
            showings.setdefault(pose.key, {})[sensor] = pose
    return list(showings.items())


def _numbered(showings: Sequence[Showing]) -> list[tuple[str, Showing]]:
    return [(f"showing {place}", showing) for place, showing in enumerate(showings, start=1)]
