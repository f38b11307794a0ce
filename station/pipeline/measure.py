"""From frames of passing wheels to results.json."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, WheelFrame, each_wheel
from station.documents import CalibrationDocument, MeasurementDocument, WheelDocument
from station.errors import InputUnusable
from station.pipeline.batches import Batch, batches_of
from station.pipeline.cores import Cores, these_or_all_cores
from station.pipeline.frames import count_frames
from station.pipeline.gauge import UnreadBatch, WheelGauge
from station.pipeline.resumption import Resumption
from station.progress import Progress, silent
from station.recording import BEGINNING
from station.software import SOFTWARE

FRAME_S = 0.025
"""What reading a frame, locating its stripe and measuring the wheel in it take."""


def measure_sources(
    sources: Sequence[Path],
    calibration: CalibrationDocument,
    *,
    reference: str = "S1002",
    limits: Limits | None = None,
    since: Resumption | None = None,
    progress: Progress = silent,
    cores: Cores | None = None,
) -> MeasurementDocument:
    """Measure every wheel in recordings, pictures or folders.

    Frames of a recording that follow each other closely are one wheel; every picture of a folder
    is a wheel of its own. A wheel that cannot be measured is a row with a reason. Alarms are
    raised by `limits`, those of practice where not given. With `since`, which is of one recording,
    only the wheels from there on are measured. It takes all cores where none are given.

    Raises
    ------
    InputUnusable
        If a source or the reference cannot be used, or a picture does not fit the camera.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable("no SOURCE given; give recordings, pictures or folders")
    gauge = WheelGauge.of(calibration, reference, limits)
    place = BEGINNING if since is None else since.of(calibration.sensor)
    total = max(count_frames(sources) - place.frames, 1)

    def refuse(unread: UnreadBatch) -> None:
        raise unread.error

    def report(done: int) -> None:
        progress(done / total, f"frame {done} of {total}")

    with these_or_all_cores(cores, alone_s=total * FRAME_S) as those:
        wheels = tuple(
            measured_wheels(
                batches_of(sources, place),
                gauge,
                those,
                unread=refuse,
                frames_done=report,
                shown_before=since is not None and since.shown_before,
            )
        )
    return measured_by_sensor(calibration, gauge, wheels)


def measured_by_sensor(
    calibration: CalibrationDocument, gauge: WheelGauge, wheels: Sequence[WheelDocument]
) -> MeasurementDocument:
    """Return the document of wheels that a gauge made of a calibration has measured."""
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=calibration.fingerprint,
        reference=gauge.reference.name,
        regime=gauge.limits.regime,
        wheels=tuple(wheels),
    )


def measured_wheels(
    batches: Iterable[Batch],
    gauge: WheelGauge,
    cores: Cores,
    *,
    unread: Callable[[UnreadBatch], None],
    frames_done: Callable[[int], None],
    shown_before: bool = False,
) -> Iterator[WheelDocument]:
    """Measure wheel after wheel, in order, with the stripes of a few in memory.

    Parameters
    ----------
    batches
        Frames in the order they were taken; taken a few ahead of the wheels.
    gauge
        What to measure with.
    cores
        Where to.
    unread
        Called with a batch that could not be read; the work goes on where it returns.
    frames_done
        Called with the number of frames in which the stripe has been looked for.
    shown_before
        As of `each_wheel`.
    """

    def frames() -> Iterator[WheelFrame]:
        done = 0
        for answer in cores.map(gauge.locate, batches):
            if isinstance(answer, UnreadBatch):
                unread(answer)
                continue
            done += len(answer)
            frames_done(done)
            yield from answer

    yield from cores.map(gauge.measure, each_wheel(frames(), shown_before=shown_before))
