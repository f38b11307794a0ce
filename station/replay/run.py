"""Measuring recordings again: the same steps as a pass's, as fast as the cores go."""

from collections.abc import Callable, Iterator, Mapping, MutableMapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, Side
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.errors import InputUnusable, StationError
from station.exports import table_writer
from station.pictures import RECORDING_SUFFIX
from station.pipeline import (
    FRAME_S,
    Batch,
    Cores,
    RigGauge,
    UnreadBatch,
    WheelGauge,
    all_cores,
    distinct_names,
    measured_on_rig,
    measured_wheels,
    recorded_batches,
)
from station.progress import Progress, silent
from station.recording import info, parts_of, whole_recordings
from station.replay.passes import Lookers, wheels_of_passes
from station.replay.report import Refusal, ReplayReport
from station.replay.spool import Spool
from station.settings import MAX_SKEW_US
from station.software import SOFTWARE

Parts = Sequence[Path]


def replay_recordings(
    files: Sequence[Path],
    calibration: CalibrationDocument | Sequence[CalibrationDocument],
    out: Path,
    *,
    rigs: Sequence[RigDocument] = (),
    reference: str = "S1002",
    limits: Limits | None = None,
    sides: Mapping[str, Side] | None = None,
    max_skew_us: Mapping[str, float] | None = None,
    progress: Progress = silent,
) -> ReplayReport:
    """Measure the wheels in recordings and write them to a table.

    Of a recording that is damaged, or of a sensor without calibration, nothing is in the table,
    and the others are measured all the same. What is in memory does not grow with the recordings.

    Parameters
    ----------
    files
        Recordings of the calibration's sensor, or of several sensors with a calibration of each.
    calibration
        With those of several sensors, the wheels of each pass stand axle for axle. Those of a rig's
        sensors are taken in place of what the rig rests on.
    out
        The table.
    rigs
        Sensors that are measured together.
    reference, limits, progress
        As of a measurement.
    sides
        The side of the train that each of several sensors looks at.
    max_skew_us
        Greatest time between frames of one shot, of single rigs.

    Raises
    ------
    InputUnusable
        If a file is no recording by its name or given twice, two calibrations are of one sensor,
        two rigs share one, or the table cannot be written.
    """
    write = table_writer(out)
    given = [calibration] if isinstance(calibration, CalibrationDocument) else list(calibration)
    lookers = _lookers(given, rigs, sides or {}, reference, limits)
    refused: dict[str, str] = {}
    work = _Work(_recordings(files, refused), lookers, max_skew_us or {}, refused, progress)
    with Spool(out.parent) as spool:
        with all_cores(alone_s=work.tally.total * FRAME_S) as cores:
            for wheel in work.wheels(cores):
                spool.add(wheel)
        wheels = spool.wheels(without=refused)
        write(out, _heading(given, rigs, lookers), work.tally.counted(wheels))
    return ReplayReport(
        out=out,
        recordings=len(work.recordings.keys() - refused.keys()),
        frames=work.tally.frames,
        wheels=work.tally.wheels,
        measured=work.tally.measured,
        refused=tuple(Refusal(name, reason) for name, reason in refused.items()),
    )


class _Work:
    """What is to be measured, and with what; recordings it cannot use it adds to `refused`."""

    def __init__(
        self,
        recordings: Mapping[str, Parts],
        lookers: Lookers,
        max_skew_us: Mapping[str, float],
        refused: MutableMapping[str, str],
        progress: Progress,
    ) -> None:
        self.recordings = recordings
        self._lookers, self._max_skew_us, self._refused = lookers, max_skew_us, refused
        total = max(1, sum(_frames_in(parts) for parts in recordings.values()))
        self.tally = _Tally(total, progress)

    def wheels(self, cores: Cores) -> Iterator[WheelDocument]:
        """Yield the wheels: of one sensor in order, of several pass for pass."""

        def measured(chosen: Mapping[str, Parts], gauge: WheelGauge) -> Iterator[WheelDocument]:
            return measured_wheels(
                _batches(chosen, self._refused),
                gauge,
                cores,
                unread=self._refuse,
                frames_done=self.tally.series(),
            )

        def on_rig(chosen: Mapping[str, str], gauge: RigGauge) -> Iterator[WheelDocument]:
            return measured_on_rig(
                {
                    sensor: _batches({name: self.recordings[name]}, self._refused)
                    for sensor, name in chosen.items()
                },
                gauge,
                cores,
                max_skew_us=self._max_skew_us.get(gauge.rig_id, MAX_SKEW_US),
                unread=self._refuse,
                frames_done=self.tally.series(),
            )

        lookers = self._lookers
        if len(lookers.gauges) == 1 and not lookers.rigs:
            return measured(self.recordings, *lookers.gauges.values())
        return wheels_of_passes(self.recordings, lookers, self._refused, measured, on_rig)

    def _refuse(self, unread: UnreadBatch) -> None:
        self._refused.setdefault(unread.source, str(unread.error))


def _lookers(
    calibrations: Sequence[CalibrationDocument],
    rigs: Sequence[RigDocument],
    sides: Mapping[str, Side],
    reference: str,
    limits: Limits | None,
) -> Lookers:
    by_sensor = {one.sensor: one for one in calibrations}
    if len(by_sensor) < len(calibrations):
        raise InputUnusable("two calibrations of one sensor; give one of each sensor")
    in_rigs = [name for rig in rigs for name in rig.names]
    if len(set(in_rigs)) < len(in_rigs):
        raise InputUnusable("two rigs have a sensor in common; give one rig of each sensor")
    return Lookers(
        gauges={
            sensor: WheelGauge.of(one, reference, limits)
            for sensor, one in by_sensor.items()
            if sensor not in in_rigs
        },
        rigs={
            rig.rig: RigGauge.of(
                rig,
                reference,
                limits,
                calibrations=[by_sensor[name] for name in rig.names if name in by_sensor],
            )
            for rig in rigs
        },
        sides={**sides, **{rig.rig: rig.side for rig in rigs}},
    )


def _heading(
    calibrations: Sequence[CalibrationDocument], rigs: Sequence[RigDocument], lookers: Lookers
) -> MeasurementDocument:
    prints = {name: print_ for rig in rigs for name, print_ in rig.calibrations.items()}
    prints |= {one.sensor: one.fingerprint for one in calibrations}
    alone = len(prints) == 1
    gauge = lookers.first
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=next(iter(prints.values())) if alone else None,
        calibrations={} if alone else prints,
        rigs={rig.rig: rig.fingerprint for rig in rigs},
        reference=gauge.reference.name,
        regime=gauge.limits.regime,
        wheels=(),
    )


class _Tally:
    """Counts what is done, and tells how far it is."""

    def __init__(self, total: int, progress: Progress) -> None:
        self.total, self._progress = total, progress
        self.frames = self.wheels = self.measured = 0

    def series(self) -> Callable[[int], None]:
        """Return what takes the count of frames of recordings that are measured next."""
        before = self.frames

        def frames_done(count: int) -> None:
            self.frames = before + count
            done = min(1.0, self.frames / self.total)
            self._progress(done, f"frame {self.frames} of {self.total}")

        return frames_done

    def counted(self, wheels: Iterator[WheelDocument]) -> Iterator[WheelDocument]:
        for wheel in wheels:
            self.wheels += 1
            self.measured += wheel.reason is None
            yield wheel


def _recordings(files: Sequence[Path], refused: MutableMapping[str, str]) -> dict[str, Parts]:
    """Return the files of each recording by a name that tells it from the others."""
    for file in files:
        if file.suffix.lower() != RECORDING_SUFFIX:
            raise InputUnusable(
                f"{file}: not a recording (.mcap) by its name; `station measure` measures pictures"
            )
    names = dict(zip(files, distinct_names(files), strict=True))
    sound = []
    for file in files:
        try:
            _frames_in(parts_of(file))
        except StationError as error:
            refused[names[file]] = str(error)
        else:
            sound.append(file)
    return {names[parts[0]]: parts for parts in whole_recordings(sound)}


def _frames_in(parts: Parts) -> int:
    return sum(sensor.frames for part in parts for sensor in info(part).sensors)


def _batches(recordings: Mapping[str, Parts], refused: MutableMapping[str, str]) -> Iterator[Batch]:
    """Yield the frames of all recordings; of one that turns out to be damaged, no more."""
    for name, parts in recordings.items():
        try:
            for batch in recorded_batches(parts, name):
                if name in refused:
                    break
                yield batch
        except StationError as error:
            refused[name] = str(error)
