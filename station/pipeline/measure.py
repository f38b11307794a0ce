"""From frames of passing wheels to results.json."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from calib import LaserSensor, Picture, StripePoints, locate_stripe
from measure import (
    Mounting,
    ReferenceProfile,
    WheelFrame,
    group_into_wheels,
    measure_wheel,
)
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    WheelDocument,
    wheel_document,
)
from station.errors import InputUnusable
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import Frame, count_frames, read_frames
from station.pipeline.references import load_reference
from station.progress import Progress, silent
from station.software import SOFTWARE

_STRIPE_S = 0.02
"""What locating the stripe in one frame takes."""


def measure_sources(
    sources: Sequence[Path],
    calibration: CalibrationDocument,
    *,
    reference: str = "S1002",
    progress: Progress = silent,
) -> MeasurementDocument:
    """Measure every wheel in recordings, pictures or folders.

    Frames of a recording that follow each other closely are one wheel; every picture of a folder
    is a wheel of its own. A wheel that cannot be measured is a row with a reason.

    Raises
    ------
    InputUnusable
        If a source or the reference cannot be used, or a picture does not fit the camera.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable("no SOURCE given; give recordings, pictures or folders")
    profile = load_reference(reference)
    sensor = calibration.laser_sensor()
    mounting = _mounting(calibration)
    frames = _with_stripes(sources, sensor, calibration.sensor, progress)
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=calibration.fingerprint,
        reference=profile.name,
        wheels=tuple(
            _measure(wheel, sensor, profile, mounting, calibration.sensor)
            for wheel in group_into_wheels(list(frames))
        ),
    )


def _mounting(calibration: CalibrationDocument) -> Mounting | None:
    if calibration.mounting is None:
        return None
    return Mounting(
        rig_from_camera=calibration.mounting.rig_from_camera(),
        wheel_radius_mm=calibration.mounting.wheel_radius_mm,
    )


def _with_stripes(
    sources: Sequence[Path], sensor: LaserSensor, sensor_id: str, progress: Progress
) -> Iterator[WheelFrame]:
    total = count_frames(sources)
    seen: list[tuple[str, int, int | None]] = []

    def pictures() -> Iterator[Picture]:
        for frame in read_frames(sources):
            _check(frame, sensor, sensor_id)
            seen.append((frame.source, frame.number, frame.time_ns))
            yield frame.picture

    stripes: Iterator[StripePoints] = map_on_all_cores(
        locate_stripe, pictures(), count=total, seconds_each=_STRIPE_S
    )
    for done, stripe in enumerate(stripes):
        source, number, time_ns = seen[done]
        progress((done + 1) / total, f"frame {done + 1} of {total}")
        yield WheelFrame(stripe=stripe, frame=number, source=source, time_ns=time_ns)


def _check(frame: Frame, sensor: LaserSensor, sensor_id: str) -> None:
    height, width = frame.picture.shape
    if (width, height) != (sensor.camera.width, sensor.camera.height):
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but the calibration is of "
            f"{sensor.camera.width} x {sensor.camera.height}; give pictures of the same camera"
        )
    if frame.sensor not in {None, sensor_id}:
        raise InputUnusable(
            f"{frame.name} is of sensor {frame.sensor} but the calibration is of {sensor_id}; "
            "give the calibration of that sensor"
        )


def _measure(
    frames: Sequence[WheelFrame],
    sensor: LaserSensor,
    reference: ReferenceProfile,
    mounting: Mounting | None,
    sensor_id: str,
) -> WheelDocument:
    answer = measure_wheel(frames, sensor, reference, mounting=mounting)
    best = answer.quality.best_frame
    chosen = next((frame for frame in frames if frame.frame == best), frames[0])
    return wheel_document(
        answer,
        source=chosen.source,
        sensor=sensor_id,
        frame=chosen.frame,
        frames=tuple(frame.frame for frame in frames),
        time=_utc(chosen.time_ns),
    )


def _utc(time_ns: int | None) -> datetime | None:
    return None if time_ns is None else datetime.fromtimestamp(time_ns / 1e9, UTC)
