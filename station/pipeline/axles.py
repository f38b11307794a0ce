"""Wheels of several sensors put on the axles of one train, those nobody saw among them."""

from collections.abc import Iterator, Mapping, Sequence

from measure import Axle, SeenWheel, Side, Track, assemble_train
from station.documents import WheelDocument

Seen = Mapping[str, Sequence[WheelDocument]]
"""The wheels of each sensor, by its name; also of one that saw none."""


def on_axles(
    seen: Seen, sides: Mapping[str, Side], *, counted: int | None = None
) -> tuple[WheelDocument, ...]:
    """Return the wheels with axle and side, in the order of passing.

    Parameters
    ----------
    seen
        Wheels of one pass, each with a time.
    sides
        The side that each sensor looks at.
    counted
        Axles of the train; None where nobody counted them.

    Returns
    -------
    wheels
        All of them, and a row with a reason for each that the sensors of its side did not see.
    """
    wheels = [wheel for own in seen.values() for wheel in own]
    keys = iter(range(len(wheels)))
    tracks = [
        Track(
            sensor,
            sides[sensor],
            tuple(_seen(next(keys), wheel) for wheel in own),
            silent=None if own else "no wheel was seen",
        )
        for sensor, own in seen.items()
    ]
    axles = assemble_train(tracks, counted=counted)
    return tuple(row for axle in axles for row in _rows(axle, wheels, tracks))


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
