"""The recordings of one pass, by several sensors, measured axle for axle."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from measure import Side
from station.documents import WheelDocument
from station.pipeline import RigGauge, WheelGauge, on_axles

Measured = Callable[[str, WheelGauge], Iterator[WheelDocument]]
"""Yields the wheels in a recording, whose name is given."""
MeasuredOnRig = Callable[[Mapping[str, str], RigGauge], Iterator[WheelDocument]]
"""Yields the wheels in recordings of a rig's sensors, whose names are given by sensor."""


@dataclass(frozen=True, slots=True)
class Lookers:
    """What looks at the train.

    Attributes
    ----------
    gauges
        Of sensors by themselves, by sensor.
    rigs
        Of sensors that look at the same wheel, by rig.
    sides
        The side of each, where it is known: wheels of the others are put on no axle.
    """

    gauges: Mapping[str, WheelGauge]
    rigs: Mapping[str, RigGauge] = field(default_factory=dict)
    sides: Mapping[str, Side] = field(default_factory=dict)

    @property
    def first(self) -> WheelGauge | RigGauge:
        """One of them: all have the same reference and limits."""
        every: list[WheelGauge | RigGauge] = [*self.gauges.values(), *self.rigs.values()]
        return every[0]


def wheels_of_pass(
    one_pass: Mapping[str, str],
    lookers: Lookers,
    refused: Mapping[str, str],
    measured: Measured,
    measured_on_rig: MeasuredOnRig,
) -> Iterator[WheelDocument]:
    """Yield the wheels of a pass, each with axle and side; all are in memory.

    Parameters
    ----------
    one_pass
        The name of each sensor's recording.
    lookers
        What to measure with.
    refused
        Recordings of which nothing is used, and why; is added to by what measures.
    measured, measured_on_rig
        How to measure.
    """
    seen = {
        sensor: tuple(measured(name, lookers.gauges[sensor]))
        for sensor, name in one_pass.items()
        if sensor in lookers.gauges
    }
    sound = {sensor: own for sensor, own in seen.items() if one_pass[sensor] not in refused}
    for rig, gauge in lookers.rigs.items():
        own = {name: one_pass[name] for name in gauge.rig.names if name in one_pass}
        wheels = _seen_by_rig(own, gauge, refused, measured_on_rig)
        if wheels is not None:
            sound[rig] = wheels
    known = {looker: wheels for looker, wheels in sound.items() if looker in lookers.sides}
    yield from on_axles(known, lookers.sides)
    for looker, wheels in sound.items():
        if looker not in lookers.sides:
            yield from wheels


def _seen_by_rig(
    recordings: Mapping[str, str],
    gauge: RigGauge,
    refused: Mapping[str, str],
    measured_on_rig: MeasuredOnRig,
) -> tuple[WheelDocument, ...] | None:
    """Return what a rig saw; None where nothing of it was recorded, or all is damaged.

    What turns out to be damaged is left out, and the others are measured once more without it.
    """
    while True:
        sound = {sensor: name for sensor, name in recordings.items() if name not in refused}
        if not sound:
            return None
        missing = {
            sensor: refused.get(recordings.get(sensor, ""), "no recording")
            for sensor in gauge.rig.names
            if sensor not in sound
        }
        wheels = tuple(measured_on_rig(sound, replace(gauge, silent=missing)))
        if refused.keys().isdisjoint(sound.values()):
            return wheels
