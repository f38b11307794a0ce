"""Wheels of several sensors put on the axles of one train, those nobody saw among them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from measure import Axle, Limits, SeenWheel, Side, Track, assemble_train
from station.back_to_back import back_to_back_of
from station.documents import AxleDocument, StandingDocument, WheelDocument
from station.settings import TrackSettings

Seen = Mapping[str, Sequence[WheelDocument]]
"""The wheels of each sensor, by its name; also of one that saw none."""


@dataclass(frozen=True, slots=True)
class WheelsOnAxles:
    """The wheels of one pass, put on the axles of its train."""

    axles: tuple[Axle, ...]
    wheels: tuple[WheelDocument, ...]
    """What the keys of the axles' wheels number."""
    tracks: tuple[Track, ...]

    @classmethod
    def of(cls, seen: Seen, sides: Mapping[str, Side], *, counted: int | None = None) -> Self:
        """Put wheels on axles.

        Parameters
        ----------
        seen
            Wheels of one pass, each with a time.
        sides
            The side that each sensor looks at.
        counted
            Axles of the train; None where nobody counted them.
        """
        wheels = tuple(wheel for own in seen.values() for wheel in own)
        keys = iter(range(len(wheels)))
        tracks = tuple(
            Track(
                sensor,
                sides[sensor],
                tuple(_seen(next(keys), wheel) for wheel in own),
                silent=None if own else "no wheel was seen",
            )
            for sensor, own in seen.items()
        )
        return cls(assemble_train(tracks, counted=counted), wheels, tracks)

    @property
    def rows(self) -> tuple[WheelDocument, ...]:
        """All wheels with axle and side, in the order of passing.

        A wheel that the sensors of its side did not see is a row with a reason.
        """
        return tuple(row for axle in self.axles for row in _rows(axle, self.wheels, self.tracks))

    @property
    def both_sides(self) -> bool:
        """Whether sensors look at both sides of the train."""
        return len({track.side for track in self.tracks}) == len(Side)

    def distances(self, track: TrackSettings, limits: Limits) -> tuple[AxleDocument, ...]:
        """Return the distance between the flange backs of each axle."""
        return tuple(
            AxleDocument(
                axle=axle.number,
                placing=axle.placing,
                back_to_back=back_to_back_of(
                    self._standing(axle, Side.LEFT),
                    self._standing(axle, Side.RIGHT),
                    track,
                    limits,
                ),
            )
            for axle in self.axles
        )

    def _standing(self, axle: Axle, side: Side) -> list[StandingDocument]:
        seen = (self.wheels[key].standing for key in axle.wheel(side).keys)
        return [standing for standing in seen if standing is not None]


def on_axles(
    seen: Seen, sides: Mapping[str, Side], *, counted: int | None = None
) -> tuple[WheelDocument, ...]:
    """Return the wheels with axle and side, in the order of passing; see `WheelsOnAxles`."""
    return WheelsOnAxles.of(seen, sides, counted=counted).rows


def _seen(key: int, wheel: WheelDocument) -> SeenWheel:
    if wheel.time is None:
        raise ValueError(f"a wheel without a time has no place in a train: {wheel.source}")
    return SeenWheel(key, wheel.time.timestamp(), min(wheel.frames), max(wheel.frames))


def _rows(
    axle: Axle, wheels: Sequence[WheelDocument], tracks: Sequence[Track]
) -> Iterator[WheelDocument]:
    for side in Side:
        facing = [track.sensor for track in tracks if track.side is side]
        found = axle.wheel(side)
        for key in found.keys:
            yield wheels[key].model_copy(
                update={"axle": axle.number, "side": side, "placing": axle.placing}
            )
        if found.reason is not None and facing:
            yield WheelDocument(
                source="",
                sensor=facing[0],
                axle=axle.number,
                side=side,
                placing=axle.placing,
                reason=f"not seen: {found.reason}",
            )
