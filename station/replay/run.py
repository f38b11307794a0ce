"""Measuring recordings again: the same steps as a pass's, as fast as the cores go."""

from collections.abc import Iterator, MutableMapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from station.documents import CalibrationDocument, MeasurementDocument, WheelDocument
from station.errors import InputUnusable, StationError
from station.pictures import RECORDING_SUFFIX
from station.pipeline import (
    FRAME_S,
    Batch,
    UnreadBatch,
    WheelGauge,
    all_cores,
    distinct_names,
    measured_wheels,
    recorded_batches,
)
from station.progress import Progress, silent
from station.recording import info, parts_of, whole_recordings
from station.replay.report import Refusal, ReplayReport
from station.replay.spool import Spool
from station.replay.tables import table_writer
from station.software import SOFTWARE

Parts = Sequence[Path]


def replay_recordings(
    files: Sequence[Path],
    calibration: CalibrationDocument,
    out: Path,
    *,
    reference: str = "S1002",
    progress: Progress = silent,
) -> ReplayReport:
    """Measure the wheels in recordings of one sensor and write them to a table.

    Of a recording that is damaged, or of another sensor, nothing is in the table, and the others
    are measured all the same. What is in memory does not grow with the recordings.

    Raises
    ------
    InputUnusable
        If a file is no recording by its name or given twice, or the table cannot be written.
    """
    write = table_writer(out)
    gauge = WheelGauge.of(calibration, reference)
    heading = MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=calibration.fingerprint,
        reference=gauge.reference.name,
        wheels=(),
    )
    refused: dict[str, str] = {}
    recordings = _recordings(files, refused)
    total = max(1, sum(_frames_in(parts) for parts in recordings.values()))
    tally = _Tally(total, progress)

    def refuse(unread: UnreadBatch) -> None:
        refused.setdefault(unread.source, str(unread.error))

    with Spool(out.parent) as spool:
        with all_cores(alone_s=total * FRAME_S) as cores:
            batches = _batches(recordings, refused)
            for wheel in measured_wheels(
                batches, gauge, cores, unread=refuse, frames_done=tally.frames_done
            ):
                spool.add(wheel)
        write(out, heading, tally.counted(spool.wheels(without=refused)))
    return ReplayReport(
        out=out,
        recordings=len(recordings.keys() - refused.keys()),
        frames=tally.frames,
        wheels=tally.wheels,
        measured=tally.measured,
        refused=tuple(Refusal(name, reason) for name, reason in refused.items()),
    )


class _Tally:
    """Counts what is done, and tells how far it is."""

    def __init__(self, total: int, progress: Progress) -> None:
        self._total, self._progress = total, progress
        self.frames = self.wheels = self.measured = 0

    def frames_done(self, count: int) -> None:
        self.frames = count
        self._progress(min(1.0, count / self._total), f"frame {count} of {self._total}")

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


def _batches(recordings: dict[str, Parts], refused: MutableMapping[str, str]) -> Iterator[Batch]:
    """Yield the frames of all recordings; of one that turns out to be damaged, no more."""
    for name, parts in recordings.items():
        try:
            for batch in recorded_batches(parts, name):
                if name in refused:
                    break
                yield batch
        except StationError as error:
            refused[name] = str(error)
