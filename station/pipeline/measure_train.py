"""From the recordings that several sensors made of one pass to results.json, axle for axle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, Side
from station.back_to_back import NO_TRACK
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
)
from station.errors import InputUnusable
from station.pipeline.axles import WheelsOnAxles
from station.pipeline.frames import files_by_source, is_recording
from station.pipeline.measure import measure_sources
from station.pipeline.measure_rig import measure_rig
from station.progress import Progress, silent
from station.recording import info
from station.settings import MAX_SKEW_US, TrackSettings
from station.software import SOFTWARE


def measure_train(
    sources: Sequence[Path],
    calibrations: Sequence[CalibrationDocument],
    *,
    rigs: Sequence[RigDocument] = (),
    sides: Mapping[str, Side],
    max_skew_us: Mapping[str, float] | None = None,
    counted: int | None = None,
    track: TrackSettings | None = None,
    reference: str = "S1002",
    limits: Limits | None = None,
    progress: Progress = silent,
) -> MeasurementDocument:
    """Measure the wheels of one pass in the recordings of its sensors, and put them on axles.

    Parameters
    ----------
    sources
        One recording of each sensor, all of the same pass.
    calibrations
        One of each sensor; of one in a rig where it is to be taken in place of the rig's own.
    rigs
        Sensors that are measured together.
    sides
        The side of the train that each sensor in no rig looks at.
    max_skew_us
        Greatest time between frames of one shot, of single rigs.
    counted
        Axles of the train; None where nobody counted them: no axle's number is certain then.
    track
        How left and right stand to each other, for the distance between flange backs.
    reference, limits, progress
        As of `measure_sources`.

    Raises
    ------
    InputUnusable
        If a source is no recording, a sensor has no recording, calibration or side, or two of
        one; or what `measure_sources` and `measure_rig` refuse.
    RecordingUnreadable
        If a recording is damaged.
    """
    lookers = _lookers(calibrations, rigs)
    recordings = _recordings(sources)
    _ensure_known(recordings, lookers, sides)
    seen: dict[str, MeasurementDocument] = {}
    looking = [looker for looker in lookers.values() if looker.recorded(recordings)]
    for place, looker in enumerate(looking):
        seen[looker.name] = looker.measure(
            recordings,
            max_skew_us=(max_skew_us or {}).get(looker.name, MAX_SKEW_US),
            reference=reference,
            limits=limits,
            progress=_part(progress, place, len(looking)),
        )
    if not seen:
        raise InputUnusable("no SOURCE given; give a recording of each sensor")
    train = WheelsOnAxles.of(
        {name: found.wheels for name, found in seen.items()},
        {**sides, **{rig.rig: rig.side for rig in rigs}},
        counted=counted,
    )
    return _with_axles(_joined(seen, train), train, track, limits)


@dataclass(frozen=True, slots=True)
class _Looker:
    """What looks at one side of the train: a sensor, or a rig of several."""

    rig: RigDocument | None
    calibrations: tuple[CalibrationDocument, ...]

    @property
    def name(self) -> str:
        return self.calibrations[0].sensor if self.rig is None else self.rig.rig

    @property
    def sensors(self) -> tuple[str, ...]:
        return (self.name,) if self.rig is None else self.rig.names

    def recorded(self, recordings: Mapping[str, Path]) -> dict[str, Path]:
        """Return the recordings of its sensors."""
        return {sensor: recordings[sensor] for sensor in self.sensors if sensor in recordings}

    def measure(
        self,
        recordings: Mapping[str, Path],
        *,
        max_skew_us: float,
        reference: str,
        limits: Limits | None,
        progress: Progress,
    ) -> MeasurementDocument:
        own = self.recorded(recordings)
        if self.rig is None:
            (calibration,) = self.calibrations
            found = measure_sources(
                list(own.values()),
                calibration,
                reference=reference,
                limits=limits,
                progress=progress,
            )
            return found.model_copy(update={"calibrations": {self.name: calibration.fingerprint}})
        return measure_rig(
            own,
            self.rig,
            calibrations=self.calibrations,
            max_skew_us=max_skew_us,
            reference=reference,
            limits=limits,
            progress=progress,
        )


def _lookers(
    calibrations: Sequence[CalibrationDocument], rigs: Sequence[RigDocument]
) -> dict[str, _Looker]:
    """Return what looks at the train, by each of its sensors."""
    by_sensor = {each.sensor: each for each in calibrations}
    if len(by_sensor) < len(calibrations):
        raise InputUnusable("two calibrations of one sensor; give one of each sensor")
    taken = [name for rig in rigs for name in rig.names]
    if len(set(taken)) < len(taken):
        raise InputUnusable("two rigs have a sensor in common; give one rig of each sensor")
    alone = [_Looker(None, (each,)) for each in calibrations if each.sensor not in taken]
    together = [
        _Looker(rig, tuple(by_sensor[name] for name in rig.names if name in by_sensor))
        for rig in rigs
    ]
    return {sensor: looker for looker in [*together, *alone] for sensor in looker.sensors}


def _joined(seen: Mapping[str, MeasurementDocument], train: WheelsOnAxles) -> MeasurementDocument:
    first = next(iter(seen.values()))
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=None,
        calibrations={k: v for found in seen.values() for k, v in found.calibrations.items()},
        rigs={name: print_ for found in seen.values() for name, print_ in found.rigs.items()},
        reference=first.reference,
        regime=first.regime,
        wheels=train.rows,
    )


def _with_axles(
    document: MeasurementDocument,
    train: WheelsOnAxles,
    track: TrackSettings | None,
    limits: Limits | None,
) -> MeasurementDocument:
    """Add what both wheels of an axle say together, where both sides are looked at."""
    if not train.both_sides:
        return document
    if track is None:
        return document.model_copy(update={"no_back_to_back": NO_TRACK})
    axles = train.distances(track, limits if limits is not None else Limits.default())
    return document.model_copy(update={"axles": axles})


def _part(progress: Progress, place: int, of: int) -> Progress:
    return lambda done, what: progress((place + done) / of, what)


def _recordings(sources: Sequence[Path]) -> dict[str, Path]:
    """Return the recording of each sensor, by its first file."""
    found: dict[str, Path] = {}
    for files in files_by_source(sources):
        if not files:
            continue  # a later file of another source
        if not is_recording(files[0]):
            raise InputUnusable(
                f"{files[0]} does not say of which sensor it is; give recordings, or the "
                "calibration of its sensor alone"
            )
        sensors = [one.sensor for one in info(files[0]).sensors]
        if len(sensors) != 1:
            raise InputUnusable(f"{files[0]} holds {len(sensors)} sensors; allowed: one")
        (sensor,) = sensors
        if sensor in found:
            raise InputUnusable(
                f"{found[sensor]} and {files[0]} are both of sensor {sensor}; give one recording "
                "of each sensor, all of the same pass"
            )
        found[sensor] = files[0]
    return found


def _ensure_known(
    recordings: Mapping[str, Path], lookers: Mapping[str, _Looker], sides: Mapping[str, Side]
) -> None:
    for sensor, path in recordings.items():
        if sensor not in lookers:
            raise InputUnusable(
                f"{path} is of sensor {sensor} but the calibrations are of "
                f"{', '.join(lookers)}; give its calibration too"
            )
        if lookers[sensor].rig is None and sensor not in sides:
            raise InputUnusable(
                f"the side of sensor {sensor} is not known; give --config station.toml that has it"
            )
