"""Which wheelsets a train runs on, in the order in which they pass."""

from collections import Counter
from dataclasses import asdict, dataclass
from enum import StrEnum

from measure import Side
from station.errors import InputUnusable
from station.store import JsonObject


class Orientation(StrEnum):
    """Which way round a wheelset runs: `reversed` has its left wheel on the train's right."""

    FORWARD = "forward"
    REVERSED = "reversed"


@dataclass(frozen=True, slots=True)
class Wheelset:
    """A wheelset in a train: its name, its vehicle and place there, and which way round it runs."""

    wheelset: str
    vehicle: str | None = None
    position: str | None = None
    orientation: Orientation = Orientation.FORWARD

    def own_side(self, side: Side) -> Side:
        """Return which of its own wheels is on a side of the train."""
        if self.orientation is Orientation.FORWARD:
            return side
        return Side.RIGHT if side is Side.LEFT else Side.LEFT


class Named(StrEnum):
    """When the controller named a consist."""

    COMING = "coming"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class Consist:
    """The wheelsets of a train, and when they were named: a call that comes again is compared.

    Raises
    ------
    InputUnusable
        If one is named twice: no wheelset is in two places of a train.
    """

    wheelsets: tuple[Wheelset, ...]
    named: Named = Named.COMING

    def __post_init__(self) -> None:
        counted = Counter(each.wheelset for each in self.wheelsets)
        twice = [name for name, count in counted.items() if count > 1]
        if twice:
            raise InputUnusable(f"consist names wheelset {twice[0]!r} twice; give each once")

    @classmethod
    def from_json(cls, kept: JsonObject) -> "Consist":
        """Return the consist that `to_json` gave."""
        return cls(
            tuple(
                Wheelset(**{**each, "orientation": Orientation(each["orientation"])})
                for each in kept["wheelsets"]
            ),
            named=Named(kept["named"]),
        )

    def to_json(self) -> JsonObject:
        """Return it as the store keeps it."""
        return {"named": self.named, "wheelsets": [asdict(each) for each in self.wheelsets]}

    def at(self, number: int | None, axles: int | None) -> Wheelset | None:
        """Return the wheelset of an axle of the train; None where the numbers do not tell it."""
        fits = axles is None or axles == len(self.wheelsets)
        if number is None or not fits or number > len(self.wheelsets):
            return None
        return self.wheelsets[number - 1]

    def misfit(self, axles: int | None) -> str | None:
        """Say why no axle of a train can be told a wheelset; None where they can."""
        if axles is None or axles == len(self.wheelsets):
            return None
        return (
            f"the consist names {len(self.wheelsets)} wheelsets but {axles} axles were counted: "
            "no axle is told its wheelset"
        )
