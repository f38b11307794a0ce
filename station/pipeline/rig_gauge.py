"""A rig made ready to measure wheels with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

from calib import Rig
from measure import (
    Diameter,
    Limits,
    ReferenceProfile,
    Shot,
    Survey,
    WheelFrame,
    measure_wheel_on_rig,
)
from station.documents import CalibrationDocument, RigDocument, WheelDocument, wheel_document
from station.errors import InputUnusable, StationError
from station.pipeline.batches import Batch
from station.pipeline.gauge import UnreadBatch, ensure_of_sensor, utc
from station.pipeline.references import load_reference
from station.pipeline.wheel_stripe import locate_wheel_stripe

_MadeOf = tuple[str, tuple[str, ...], str, Limits]


@dataclass(frozen=True, slots=True, eq=False)
class RigGauge:
    """A calibrated rig, and the profile that wear is counted from; else as a `WheelGauge`.

    Attributes
    ----------
    rig, survey
        The sensors in the rig frame, each as its newest calibration has it, and what is known of
        passing wheels.
    rig_id
        What readings call it.
    recalibrated
        Its sensors whose calibration is not the one that the rig rests on.
    silent
        Why a sensor takes no part; it is said in each row.
    """

    rig: Rig
    survey: Survey
    rig_id: str
    reference: ReferenceProfile
    made_of: _MadeOf
    """The rig and newer calibrations as JSON, the reference as it was given, the limits."""
    recalibrated: tuple[str, ...] = ()
    silent: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        document: RigDocument,
        reference: str,
        limits: Limits | None = None,
        *,
        calibrations: Sequence[CalibrationDocument] = (),
        silent: Mapping[str, str] | None = None,
    ) -> "RigGauge":
        """Make it of a rig, the name or file of a reference, and limits for alarms.

        Parameters
        ----------
        document
            The rig.
        reference, limits
            As of a `WheelGauge`.
        calibrations
            Of its sensors, where they are to be taken in place of those it rests on.
        silent
            Why a sensor takes no part, of those that take none.

        Raises
        ------
        InputUnusable
            If the rig cannot measure wheels, the reference is neither known nor a profile's file,
            or a calibration is of no sensor of the rig, or of another camera.
        """
        chosen = limits if limits is not None else Limits.default()
        made_of = (
            document.model_dump_json(),
            tuple(each.model_dump_json() for each in calibrations),
            reference,
            chosen,
        )
        gauge = _made(*made_of)
        return replace(gauge, silent=silent or {})

    @property
    def limits(self) -> Limits:
        """What raises alarms."""
        return self.made_of[-1]

    def __reduce__(
        self,
    ) -> tuple[Callable[..., "RigGauge"], tuple[_MadeOf, tuple[tuple[str, str], ...]]]:
        return _made_again, (self.made_of, tuple(self.silent.items()))

    def locate(self, task: tuple[str, Batch]) -> list[WheelFrame] | UnreadBatch:
        """Locate the stripe in each frame of a batch that a sensor took."""
        sensor, batch = task
        camera = self.rig[sensor].sensor.camera
        try:
            return [
                WheelFrame(
                    stripe=locate_wheel_stripe(ensure_of_sensor(frame, sensor, camera).picture),
                    frame=frame.number,
                    source=batch.source,
                    time_ns=frame.time_ns,
                    sensor=sensor,
                )
                for frame in batch.frames()
            ]
        except StationError as error:
            return UnreadBatch(batch.source, error, sensor)

    def measure(self, shots: Sequence[Shot]) -> WheelDocument:
        """Measure the wheel that these shots show."""
        answer = measure_wheel_on_rig(
            shots, self.rig, self.survey, self.reference, limits=self.limits
        )
        firsts = [shot.frames[0] for shot in shots]
        best = answer.quality.best_sensor, answer.quality.best_frame
        chosen = next((each for each in firsts if (each.sensor, each.frame) == best), firsts[0])
        wheel = wheel_document(
            answer,
            source=chosen.source,
            sensor=self.rig_id,
            frame=chosen.frame,
            frames=tuple(frame.frame for frame in firsts),
            time=utc(chosen.time_ns),
            reference=self.reference,
            survey=self.survey,
        )
        return wheel.model_copy(update={"quality": self._more_of(wheel.quality, answer.diameter)})

    def _more_of(
        self, quality: Mapping[str, object], diameter: Diameter | None
    ) -> dict[str, object]:
        """Add what is behind the diameter, which sensors had no part, or a newer calibration."""
        said = dict(quality)
        if diameter is not None:
            said["diameter"] = {
                "sections": diameter.sections,
                "share": diameter.share,
                "reason": diameter.reason,
            }
        known = said.get("by_sensor")
        shares = dict(known) if isinstance(known, dict) else {}
        for sensor, reason in self.silent.items():
            shares[sensor] = {"points": 0, **shares.get(sensor, {}), "reason": reason}
        if shares:
            said["by_sensor"] = shares
        if self.recalibrated:
            said["recalibrated"] = list(self.recalibrated)
        return said


def _made_again(made_of: _MadeOf, silent: tuple[tuple[str, str], ...]) -> RigGauge:
    return replace(_made(*made_of), silent=dict(silent))


@lru_cache(maxsize=4)
def _made(rig_json: str, calibrations: tuple[str, ...], reference: str, limits: Limits) -> RigGauge:
    document = RigDocument.model_validate_json(rig_json)
    rig, newer = document.to_rig(), []
    for text in calibrations:
        calibration = CalibrationDocument.model_validate_json(text)
        if calibration.sensor not in document.names:
            raise InputUnusable(
                f"the calibration is of sensor {calibration.sensor} but rig {document.rig} has "
                f"{', '.join(document.names)}"
            )
        if calibration.fingerprint == document.calibrations[calibration.sensor]:
            continue
        _ensure_same_camera(calibration, rig)
        rig = rig.with_sensor(calibration.sensor, calibration.laser_sensor())
        newer.append(calibration.sensor)
    return RigGauge(
        rig=rig,
        survey=document.survey_of_wheels(),
        rig_id=document.rig,
        reference=load_reference(reference),
        made_of=(rig_json, calibrations, reference, limits),
        recalibrated=tuple(newer),
    )


def _ensure_same_camera(calibration: CalibrationDocument, rig: Rig) -> None:
    before, now = rig[calibration.sensor].sensor.camera, calibration.camera
    if (before.width, before.height) != (now.width, now.height):
        raise InputUnusable(
            f"sensor {calibration.sensor} is calibrated for {now.width} x {now.height} px but was "
            f"for {before.width} x {before.height} when the rig was; calibrate the rig again"
        )
