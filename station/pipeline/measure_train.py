"""From the recordings that several sensors made of one pass to results.json, axle for axle."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, Side
from station.documents import CalibrationDocument, MeasurementDocument, WheelDocument
from station.errors import InputUnusable
from station.pipeline.axles import on_axles
from station.pipeline.frames import files_by_source, is_recording
from station.pipeline.measure import measure_sources
from station.progress import Progress, silent
from station.recording import info
from station.software import SOFTWARE


def measure_train(
    sources: Sequence[Path],
    calibrations: Sequence[CalibrationDocument],
    *,
    sides: Mapping[str, Side],
    counted: int | None = None,
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
        One of each sensor.
    sides
        The side of the train that each sensor looks at.
    counted
        Axles of the train; None where nobody counted them: no axle's number is certain then.
    reference, limits, progress
        As of `measure_sources`.

    Raises
    ------
    InputUnusable
        If a source is no recording, a sensor has no recording, calibration or side, or two of
        one; or what `measure_sources` refuses.
    RecordingUnreadable
        If a recording is damaged.
    """
    by_sensor = {each.sensor: each for each in calibrations}
    if len(by_sensor) < len(calibrations):
        raise InputUnusable("two calibrations of one sensor; give one of each sensor")
    recordings = _recordings(sources)
    _ensure_known(recordings, by_sensor, sides)
    seen: dict[str, tuple[WheelDocument, ...]] = {}
    measured: MeasurementDocument | None = None
    for place, (sensor, path) in enumerate(recordings.items()):
        measured = measure_sources(
            [path],
            by_sensor[sensor],
            reference=reference,
            limits=limits,
            progress=_part(progress, place, len(recordings)),
        )
        seen[sensor] = measured.wheels
    if measured is None:
        raise InputUnusable("no SOURCE given; give a recording of each sensor")
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=None,
        calibrations={sensor: by_sensor[sensor].fingerprint for sensor in recordings},
        reference=measured.reference,
        regime=measured.regime,
        wheels=on_axles(seen, sides, counted=counted),
    )


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
    recordings: Mapping[str, Path],
    calibrations: Mapping[str, CalibrationDocument],
    sides: Mapping[str, Side],
) -> None:
    for sensor, path in recordings.items():
        if sensor not in calibrations:
            raise InputUnusable(
                f"{path} is of sensor {sensor} but the calibrations are of "
                f"{', '.join(calibrations)}; give its calibration too"
            )
        if sensor not in sides:
            raise InputUnusable(
                f"the side of sensor {sensor} is not known; give --config station.toml that has it"
            )
