"""From the frames that the sensors of a rig took together to results.json."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, WheelFrame, each_shot, each_wheel
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.errors import InputUnusable, RecordingError, StationError
from station.pipeline.batches import Batch, batches_of
from station.pipeline.cores import Cores, these_or_all_cores
from station.pipeline.frames import count_frames, is_recording
from station.pipeline.gauge import UnreadBatch
from station.pipeline.measure import FRAME_S
from station.pipeline.resumption import Resumption
from station.pipeline.rig_gauge import RigGauge
from station.progress import Progress, silent
from station.recording import BEGINNING, FilePlace
from station.settings import MAX_SKEW_US
from station.software import SOFTWARE


def measure_rig(
    sources: Mapping[str, Path],
    rig: RigDocument,
    *,
    calibrations: Sequence[CalibrationDocument] = (),
    silent_sensors: Mapping[str, str] | None = None,
    all_sound: bool = True,
    max_skew_us: float = MAX_SKEW_US,
    reference: str = "S1002",
    limits: Limits | None = None,
    since: Resumption | None = None,
    progress: Progress = silent,
    cores: Cores | None = None,
) -> MeasurementDocument:
    """Measure every wheel that the sensors of a rig saw, in recordings, pictures or folders.

    Frames of recordings that the same trigger started are one shot of the wheel; pictures are
    paired in their order. A sensor without a source is said in each row.

    Parameters
    ----------
    sources
        By sensor; see `sources_by_sensor`.
    rig
        Where the sensors stand.
    calibrations
        Of its sensors, where they are to be taken in place of those it rests on.
    silent_sensors
        Why a sensor has no source, where more is known than that.
    all_sound
        Whether a damaged source is refused; else it is left out and that is said in each row, as
        long as one is whole.
    max_skew_us
        Greatest time between frames of one shot.
    reference, limits, progress, cores
        As of `measure_sources`.
    since
        Where in the recordings to begin; a damaged one is refused then: what was measured before
        that place rests on it.

    Raises
    ------
    InputUnusable
        If a source, the rig or the reference cannot be used, sources are recordings in part, or
        pictures do not pair.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable(f"no SOURCE given; give one of each of {', '.join(rig.names)}")
    _ensure_pairing(sources)
    chosen = dict(sources)
    gauge = RigGauge.of(rig, reference, limits, calibrations=calibrations)
    why = {name: "no recording" for name in rig.names if name not in chosen}
    why |= silent_sensors or {}
    while True:
        try:
            told = replace(gauge, silent=why)
            wheels = _wheels(chosen, told, max_skew_us, since, progress, cores)
            break
        except _Damaged as damaged:
            if all_sound or since is not None or len(chosen) == 1:
                raise damaged.error from damaged
            why[damaged.sensor] = str(damaged.error)
            chosen = {name: path for name, path in chosen.items() if name != damaged.sensor}
    return measured_by_rig(rig, calibrations, gauge, wheels)


def measured_by_rig(
    rig: RigDocument,
    calibrations: Sequence[CalibrationDocument],
    gauge: RigGauge,
    wheels: Sequence[WheelDocument],
) -> MeasurementDocument:
    """Return the document of wheels that a gauge made of a rig and calibrations has measured."""
    newer = {each.sensor: each.fingerprint for each in calibrations}
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=None,
        calibrations=rig.calibrations | newer,
        rigs={rig.rig: rig.fingerprint},
        reference=gauge.reference.name,
        regime=gauge.limits.regime,
        wheels=tuple(wheels),
    )


class _Damaged(Exception):
    """The source of a sensor cannot be read to its end."""

    def __init__(self, sensor: str, error: StationError) -> None:
        super().__init__(str(error))
        self.sensor, self.error = sensor, error


def _wheels(
    sources: Mapping[str, Path],
    gauge: RigGauge,
    max_skew_us: float,
    since: Resumption | None,
    progress: Progress,
    cores: Cores | None,
) -> tuple[WheelDocument, ...]:
    places = {name: BEGINNING if since is None else since.of(name) for name in sources}
    recorded = sum(_count(sensor, source) for sensor, source in sources.items())
    total = max(recorded - sum(place.frames for place in places.values()), 1)
    batches = {name: _batches(name, source, places[name]) for name, source in sources.items()}

    def report(done: int) -> None:
        progress(min(done / total, 1.0), f"frame {done} of {total}")

    with these_or_all_cores(cores, alone_s=total * FRAME_S) as those:
        return tuple(
            measured_on_rig(
                batches,
                gauge,
                those,
                max_skew_us=max_skew_us,
                unread=_refuse,
                frames_done=report,
                shown_before=since is not None and since.shown_before,
            )
        )


def _refuse(unread: UnreadBatch) -> None:
    raise _Damaged(unread.sensor, unread.error)


def _count(sensor: str, source: Path) -> int:
    try:
        return count_frames([source])
    except RecordingError as error:
        raise _Damaged(sensor, error) from error


def _batches(sensor: str, source: Path, since: FilePlace) -> Iterator[Batch]:
    try:
        yield from batches_of([source], since)
    except RecordingError as error:
        raise _Damaged(sensor, error) from error


def measured_on_rig(
    batches: Mapping[str, Iterable[Batch]],
    gauge: RigGauge,
    cores: Cores,
    *,
    max_skew_us: float,
    unread: Callable[[UnreadBatch], None],
    frames_done: Callable[[int], None],
    shown_before: bool = False,
) -> Iterator[WheelDocument]:
    """Measure wheel after wheel, in order, with the stripes of a few in memory.

    Parameters
    ----------
    batches
        Frames of each sensor in the order they were taken; taken a few ahead of the wheels.
    gauge
        What to measure with.
    cores
        Where to.
    max_skew_us
        Greatest time between frames of one shot.
    unread
        Called with a batch that could not be read; the work goes on where it returns.
    frames_done
        Called with the number of frames in which the stripe has been looked for.
    shown_before
        As of `each_wheel`.
    """
    done = 0

    def frames(sensor: str, own: Iterable[Batch]) -> Iterator[WheelFrame]:
        nonlocal done
        for answer in cores.map(gauge.locate, ((sensor, batch) for batch in own)):
            if isinstance(answer, UnreadBatch):
                unread(answer)
                continue
            done += len(answer)
            frames_done(done)
            yield from answer

    streams = {sensor: frames(sensor, own) for sensor, own in batches.items()}
    shots = each_shot(streams, max_skew_s=max_skew_us * 1e-6)
    yield from cores.map(gauge.measure, each_wheel(shots, shown_before=shown_before))


def _ensure_pairing(sources: Mapping[str, Path]) -> None:
    recorded = [is_recording(source) for source in sources.values()]
    if all(recorded):
        return
    if any(recorded):
        raise InputUnusable(
            "recordings are paired by time and pictures have none; give recordings of all sensors, "
            "or pictures of all"
        )
    counts = {sensor: count_frames([source]) for sensor, source in sources.items()}
    if len(set(counts.values())) > 1:
        told = ", ".join(f"{sensor} {count}" for sensor, count in counts.items())
        raise InputUnusable(
            f"pictures pair by order but there are of {told}; give as many of each sensor"
        )
