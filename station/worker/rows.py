"""From measured wheels to rows of the store: of one recording, or of all that a rig recorded."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.limits import limits_of
from station.pipeline import Resumption
from station.progress import Progress
from station.settings import MAX_SKEW_US
from station.store import (
    Calibration,
    Job,
    Measurement,
    Pass,
    Recording,
    RigCalibration,
    recordings_of,
    the,
)
from station.worker.context import WorkContext


@dataclass(frozen=True, slots=True)
class RecordedOnRig:
    """What the sensors of a rig recorded of a pass.

    Attributes
    ----------
    document
        The rig that was in force.
    recordings
        Of all its sensors that were armed, also those that cannot be measured.
    calibrations
        Of the sensors, as they were in force.
    """

    document: RigDocument
    recordings: tuple[Recording, ...]
    calibrations: tuple[CalibrationDocument, ...]

    @property
    def measurable(self) -> dict[str, Recording]:
        """The recordings that hold frames of a calibrated sensor, by sensor."""
        return {
            each.sensor: each
            for each in self.recordings
            if each.recorded and each.calibration_id and each.sensor in self.document.names
        }

    @property
    def silent(self) -> dict[str, str]:
        """Why a sensor of the rig has no part in the readings."""
        by_sensor = {each.sensor: each for each in self.recordings}
        return {
            name: why_silent(by_sensor.get(name))
            for name in self.document.names
            if name not in self.measurable
        }


NOT_ARMED, NO_CALIBRATION = "the sensor was not armed", "no calibration was active"


def why_silent(recording: Recording | None) -> str:
    """Say why nothing of a sensor can be measured."""
    if recording is None:
        return NOT_ARMED
    return NO_CALIBRATION if recording.recorded else "no frame was recorded"


def recorded_on_rig(context: WorkContext, job_id: str, rig_calibration_id: str) -> RecordedOnRig:
    """Return what a pass's job has to measure on a rig."""
    with context.store.look() as session:
        row = the(session, Pass, the(session, Job, job_id).subject)
        rig = the(session, RigCalibration, rig_calibration_id)
        recordings = [
            each
            for each in recordings_of(session, row)
            if each.rig_calibration_id == rig_calibration_id
        ]
        calibrations = [
            the(session, Calibration, each.calibration_id)
            for each in recordings
            if each.calibration_id is not None
        ]
    return RecordedOnRig(
        RigDocument.model_validate_json(rig.document or ""),
        tuple(recordings),
        tuple(
            CalibrationDocument.model_validate_json(each.document or "") for each in calibrations
        ),
    )


def rows_on_rig(
    context: WorkContext,
    on_rig: RecordedOnRig,
    progress: Progress,
    since: Resumption | None = None,
) -> list[Measurement]:
    """Measure the wheels that the sensors of a rig saw together; a row a wheel."""
    found = measuring_on_rig(context, on_rig)(progress=progress, since=since)
    return rows_of_rig(context, on_rig, found)


def measuring_on_rig(context: WorkContext, on_rig: RecordedOnRig) -> partial[MeasurementDocument]:
    """Return the measuring of what the sensors of a rig saw together, to be done anywhere."""
    rig = context.settings.rig(on_rig.document.rig)
    recordings = on_rig.measurable
    return partial(
        context.mathematics.measure_rig,
        {name: (context.layout.root / each.path).absolute() for name, each in recordings.items()},
        on_rig.document,
        calibrations=[each for each in on_rig.calibrations if each.sensor in recordings],
        silent_sensors=on_rig.silent,
        all_sound=False,
        max_skew_us=MAX_SKEW_US if rig is None else rig.max_skew_us,
        reference=context.settings.reference,
        limits=limits_of(context.settings.limits),
    )


def rows_of_rig(
    context: WorkContext, on_rig: RecordedOnRig, found: MeasurementDocument
) -> list[Measurement]:
    """Return the rows of what was measured on a rig."""
    recordings = on_rig.measurable
    by_file = {Path(each.path).name: each for each in recordings.values()}
    return [
        measurement_row(context, recording_of(wheel, by_file), wheel, place=at, found=found)
        for at, wheel in enumerate(found.wheels)
    ]


def recording_of(wheel: WheelDocument, by_file: Mapping[str, Recording]) -> Recording:
    """Return the recording that a wheel's frame is of, from those of its looker by file name."""
    return by_file.get(wheel.source, next(iter(by_file.values())))


def measurement_row(
    context: WorkContext,
    recording: Recording,
    wheel: WheelDocument,
    *,
    place: int,
    found: MeasurementDocument,
) -> Measurement:
    """Return the row of a wheel; a rig's is kept beside the recording its frame is of."""
    # A wheel without a frame of its own still needs a key: no camera gives a negative one.
    frame = wheel.frame if wheel.frame is not None else -1 - place
    return Measurement(
        recording_id=recording.id,
        frame=frame,
        calibration_id=recording.calibration_id,
        rig_calibration_id=recording.rig_calibration_id if found.rigs else None,
        sensor=wheel.sensor if found.rigs else recording.sensor,
        pass_id=recording.pass_id,
        reference=found.reference,
        regime=found.regime,
        software=found.software,
        measured_at=context.now(),
        wheel=wheel.model_dump(mode="json"),
    )
