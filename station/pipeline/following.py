"""Measuring wheels while the train still passes, by the steps that measure finished recordings.

What is returned for good here is what measuring the finished recordings returns: frames are
located, joined, sorted and measured by the same functions, only fed bit by bit.
"""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from measure import MAX_SKEW_S, Limits, Shot, ShotJoiner, WheelFrame, WheelSorter
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.pipeline.batches import ReadBatch
from station.pipeline.gauge import UnreadBatch, WheelGauge
from station.pipeline.measure import measured_by_sensor
from station.pipeline.measure_rig import measured_by_rig
from station.pipeline.resumption import Resumption
from station.pipeline.rig_gauge import RigGauge
from station.recording import FilePlace, RecordedFrame

Located = list[WheelFrame] | UnreadBatch
Taken = tuple[FilePlace, RecordedFrame]
_Key = tuple[tuple[str, int, int | None], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Looker:
    """A sensor or a rig: how its frames are looked at, and what is measured from them.

    Attributes
    ----------
    sensors
        Those whose frames are taken.
    locate
        Finds the stripes in frames of a sensor.
    measure
        Measures a wheel.
    document
        Puts measured wheels into the document that measuring finished recordings gives.
    max_skew_s
        Greatest time between frames of one shot.
    """

    sensors: tuple[str, ...]
    locate: Callable[[str, ReadBatch], Located]
    measure: Callable[[Sequence[Shot]], WheelDocument]
    document: Callable[[Sequence[WheelDocument]], MeasurementDocument]
    max_skew_s: float = MAX_SKEW_S


def looking_sensor(
    calibration: CalibrationDocument, *, reference: str, limits: Limits | None
) -> Looker:
    """Return a sensor that measures by itself.

    Raises
    ------
    InputUnusable
        If the reference cannot be used.
    """
    gauge = WheelGauge.of(calibration, reference, limits)
    return Looker(
        sensors=(calibration.sensor,),
        locate=lambda _, batch: gauge.locate(batch),
        measure=lambda shots: gauge.measure([shot.frames[0] for shot in shots]),
        document=partial(measured_by_sensor, calibration, gauge),
    )


def looking_rig(
    rig: RigDocument,
    *,
    calibrations: Sequence[CalibrationDocument],
    silent_sensors: Mapping[str, str],
    max_skew_us: float,
    reference: str,
    limits: Limits | None,
) -> Looker:
    """Return a rig, its sensors measuring together; see `measure_rig`.

    Raises
    ------
    InputUnusable
        If the rig or the reference cannot be used.
    """
    gauge = RigGauge.of(rig, reference, limits, calibrations=calibrations, silent=silent_sensors)
    return Looker(
        sensors=tuple(name for name in rig.names if name not in silent_sensors),
        locate=lambda sensor, batch: gauge.locate((sensor, batch)),
        measure=gauge.measure,
        document=partial(measured_by_rig, rig, calibrations, gauge),
        max_skew_s=max_skew_us * 1e-6,
    )


class WheelFollower:
    """The wheels of a pass, as its frames come.

    Parameters
    ----------
    looker
        Who looks at them.
    source
        What readings call the recording of each sensor.
    since
        Where the recordings are taken up; the frame at each place is the first one to be taken.
    """

    def __init__(self, looker: Looker, source: Mapping[str, str], since: Resumption) -> None:
        self._looker = looker
        self._source = source
        self._joiner = ShotJoiner(looker.sensors, max_skew_s=looker.max_skew_s)
        self._sorter = WheelSorter[Shot](shown_before=since.shown_before)
        self._places = {sensor: deque[FilePlace]() for sensor in looker.sensors}
        self._joined = dict.fromkeys(looker.sensors, 0)
        self._measured: dict[_Key, WheelDocument] = {}
        self.resumption = since
        """Where to go on so that just the wheels not yet returned are measured again."""

    @property
    def frames_open(self) -> int:
        """Frames behind `resumption`."""
        return sum(len(places) for places in self._places.values())

    @property
    def frames_waiting(self) -> int:
        """Frames whose stripes are in memory until another sensor's next frame comes."""
        return self._joiner.frames_waiting

    def take(self, sensor: str, frames: Sequence[Taken]) -> Iterator[WheelDocument]:
        """Take the next frames of a sensor; yield the wheels that are over, whatever follows.

        Raises
        ------
        StationError
            If a frame does not fit the sensor.
        """
        batch = ReadBatch(self._source[sensor], tuple(frame for _, frame in frames))
        located = self._looker.locate(sensor, batch)
        if isinstance(located, UnreadBatch):
            raise located.error
        for (place, _), frame in zip(frames, located, strict=True):
            self._places[sensor].append(place)
            for shot in self._joiner.add(sensor, frame):
                yield from self._sort(shot)

    def open_wheels(self) -> list[WheelDocument]:
        """Return the wheels not yet over as they are were no frame to follow."""
        groups = self._sorter.wheels_left(self._joiner.left())
        measured = {_key_of(group): self._measure(group) for group in groups}
        self._measured = measured
        return list(measured.values())

    def end(self, ends: Mapping[str, FilePlace]) -> Iterator[WheelDocument]:
        """Take it that no frame follows; yield the wheels that are over by that.

        Parameters
        ----------
        ends
            The places behind the last frames.
        """
        for sensor in self._looker.sensors:
            for shot in self._joiner.add(sensor, None):
                yield from self._sort(shot)
        yield from self.open_wheels()
        self.resumption = Resumption(ends)

    def _sort(self, shot: Shot) -> Iterator[WheelDocument]:
        group = self._sorter.add(shot)
        if group is not None:
            yield self._measure(group)
        if self._sorter.clear:
            self._resume_at_shot()
        for sensor in self._sensors_of(shot):
            self._joined[sensor] += 1

    def _resume_at_shot(self) -> None:
        """Note the place before the shot in hand: all that went before is done with."""
        for sensor, own in self._places.items():
            for _ in range(self._joined[sensor]):
                own.popleft()
            self._joined[sensor] = 0
        # A shot is certain only where every sensor has a next frame, in it or behind it.
        places = {sensor: own[0] for sensor, own in self._places.items()}
        self.resumption = Resumption(places, self._sorter.shown_before)

    def _sensors_of(self, shot: Shot) -> list[str]:
        # One that looks alone does not write its name on its frames.
        if len(self._looker.sensors) == 1:
            return list(self._looker.sensors)
        return [frame.sensor for frame in shot.frames]

    def _measure(self, group: Sequence[Shot]) -> WheelDocument:
        known = self._measured.get(_key_of(group))
        return self._looker.measure(group) if known is None else known


def _key_of(group: Sequence[Shot]) -> _Key:
    frames = (frame for shot in group for frame in shot.frames)
    # With the time: a camera that was started again numbers from 1 again.
    return tuple((frame.sensor, frame.frame, frame.time_ns) for frame in frames)
