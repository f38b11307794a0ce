"""A calibration made ready to measure wheels with."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import lru_cache

from calib import CameraModel, LaserSensor
from measure import Limits, Mounting, ReferenceProfile, WheelFrame, measure_wheel
from station.documents import CalibrationDocument, WheelDocument, wheel_document
from station.errors import InputUnusable, StationError
from station.pipeline.batches import Batch
from station.pipeline.frames import Frame
from station.pipeline.references import load_reference
from station.pipeline.wheel_stripe import locate_wheel_stripe


@dataclass(frozen=True, slots=True)
class UnreadBatch:
    """A batch that could not be read, and why: one bad source must not end the work on others."""

    source: str
    error: StationError
    sensor: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class WheelGauge:
    """A calibrated sensor, where it stands, and the profile that wear is counted from.

    Its methods are the two steps of a measurement; other processes do them for many wheels at
    once. Handed over, it is what it was made of: the receiver makes it again, once, as what
    `measure` derives from a reference it keeps for that very object.
    """

    sensor: LaserSensor
    sensor_id: str
    mounting: Mounting | None
    reference: ReferenceProfile
    made_of: tuple[str, str]
    """The calibration as JSON, and the reference as it was given."""
    limits: Limits = field(default_factory=Limits.default)

    @classmethod
    def of(
        cls, calibration: CalibrationDocument, reference: str, limits: Limits | None = None
    ) -> "WheelGauge":
        """Make it of a calibration, the name or file of a reference, and limits for alarms.

        Raises
        ------
        InputUnusable
            If the reference is neither known nor a profile's file.
        """
        return cls(
            sensor=calibration.laser_sensor(),
            sensor_id=calibration.sensor,
            mounting=None if calibration.mounting is None else calibration.mounting.mounting(),
            reference=load_reference(reference),
            made_of=(calibration.model_dump_json(), reference),
            limits=limits if limits is not None else Limits.default(),
        )

    def __reduce__(
        self,
    ) -> tuple[Callable[[str, str, Limits], "WheelGauge"], tuple[str, str, Limits]]:
        return _made_again, (*self.made_of, self.limits)

    def locate(self, batch: Batch) -> list[WheelFrame] | UnreadBatch:
        """Locate the stripe in each frame of a batch."""
        try:
            return [
                WheelFrame(
                    stripe=locate_wheel_stripe(
                        ensure_of_sensor(frame, self.sensor_id, self.sensor.camera).picture
                    ),
                    frame=frame.number,
                    source=batch.source,
                    time_ns=frame.time_ns,
                )
                for frame in batch.frames()
            ]
        except StationError as error:
            return UnreadBatch(batch.source, error)

    def measure(self, frames: Sequence[WheelFrame]) -> WheelDocument:
        """Measure the wheel that these frames show."""
        answer = measure_wheel(
            frames, self.sensor, self.reference, mounting=self.mounting, limits=self.limits
        )
        best = answer.quality.best_frame
        chosen = next((frame for frame in frames if frame.frame == best), frames[0])
        return wheel_document(
            answer,
            source=chosen.source,
            sensor=self.sensor_id,
            frame=chosen.frame,
            frames=tuple(frame.frame for frame in frames),
            time=utc(chosen.time_ns),
            reference=self.reference,
            survey=self.mounting,
        )


def ensure_of_sensor(frame: Frame, sensor: str, camera: CameraModel) -> Frame:
    """Return a frame after checking that it can be of a sensor.

    Raises
    ------
    InputUnusable
        If it is of another size than the sensor's pictures, or says that it is of another sensor.
    """
    height, width = frame.picture.shape
    if (width, height) != (camera.width, camera.height):
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but the calibration is of "
            f"{camera.width} x {camera.height}; give pictures of the same camera"
        )
    if frame.sensor not in {None, sensor}:
        raise InputUnusable(
            f"{frame.name} is of sensor {frame.sensor} but the calibration is of "
            f"{sensor}; give the calibration of that sensor"
        )
    return frame


@lru_cache(maxsize=4)
def _made_again(calibration_json: str, reference: str, limits: Limits) -> WheelGauge:
    calibration = CalibrationDocument.model_validate_json(calibration_json)
    return WheelGauge.of(calibration, reference, limits)


def utc(time_ns: int | None) -> datetime | None:
    """Return a time of the camera as a moment."""
    return None if time_ns is None else datetime.fromtimestamp(time_ns / 1e9, UTC)
