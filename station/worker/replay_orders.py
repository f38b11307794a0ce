"""What one step of a replay measures, as an order that a process without a store can carry out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from calib import CalibError
from station.documents import CalibrationDocument, MeasurementDocument, RigDocument
from station.errors import StationError
from station.limits import limits_of
from station.pipeline import Cores
from station.progress import silent
from station.replay import be_a_worker
from station.software import SOFTWARE
from station.store import Calibration, Measurement, Recording, Replay, RigCalibration, the
from station.worker.context import WorkContext
from station.worker.rows import RecordedOnRig, measurement_row, measuring_on_rig, rows_of_rig


@dataclass(frozen=True, slots=True, eq=False)
class StepOrder:
    """A recording to be measured, or those of a rig together."""

    names: tuple[str, ...]
    measure: partial[MeasurementDocument]
    """Takes the progress, and the cores to work on."""
    software: str = SOFTWARE


def carry_out(order: StepOrder) -> MeasurementDocument | str:
    """Do a step as a worker among others; return why not, where the recording is to blame.

    Raises
    ------
    OtherSoftware
        If this is another version than the one that gave the order.
    """
    be_a_worker(order.software)
    try:
        return order.measure(progress=silent, cores=Cores(None))
    except (StationError, CalibError) as error:
        return str(error)


def order_of(context: WorkContext, row: Replay, names: Sequence[str]) -> StepOrder:
    """Return the order of a step, by the recordings that it names."""
    recorded = _Recorded.of(context, row, names)
    on_rig, against = recorded.on_rig, recorded.context
    if on_rig is not None:
        return StepOrder(tuple(names), measuring_on_rig(against, on_rig))
    (recording,), (calibration,) = recorded.recordings, recorded.calibrations
    measure = partial(
        context.mathematics.measure,
        [(context.layout.root / recording.path).absolute()],
        calibration,
        reference=against.settings.reference,
        limits=limits_of(against.settings.limits),
    )
    return StepOrder(tuple(names), measure)


def rows_of(
    context: WorkContext, row: Replay, names: Sequence[str], found: MeasurementDocument
) -> list[Measurement]:
    """Return the rows of what a step measured."""
    recorded = _Recorded.of(context, row, names)
    if recorded.on_rig is not None:
        return rows_of_rig(recorded.context, recorded.on_rig, found)
    (recording,) = recorded.recordings
    return [
        measurement_row(context, recording, wheel, place=at, found=found)
        for at, wheel in enumerate(found.wheels)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class _Recorded:
    """The recordings of a step, as if they had been made under the calibrations of the replay."""

    context: WorkContext
    """With the reference of the replay."""
    recordings: tuple[Recording, ...]
    calibrations: tuple[CalibrationDocument, ...]
    rig: RigDocument | None

    @classmethod
    def of(cls, context: WorkContext, row: Replay, names: Sequence[str]) -> "_Recorded":
        against = context.settings.model_copy(update={"reference": row.reference})
        with context.store.look() as session:
            recordings = tuple(_as_if(the(session, Recording, name), row) for name in names)
            calibrations = tuple(
                CalibrationDocument.model_validate_json(
                    the(session, Calibration, row.calibrations[each.sensor]).document or ""
                )
                for each in recordings
            )
            rig_id = row.rig_calibration_id
            document = None if rig_id is None else the(session, RigCalibration, rig_id).document
        rig = None if document is None else RigDocument.model_validate_json(document)
        return cls(replace(context, settings=against), recordings, calibrations, rig)

    @property
    def on_rig(self) -> RecordedOnRig | None:
        if self.rig is None:
            return None
        return RecordedOnRig(self.rig, self.recordings, self.calibrations)


def _as_if(recording: Recording, row: Replay) -> Recording:
    """Return a recording with other calibrations than it was made under.

    It is no row of the store: what the station recorded, it recorded under its own.
    """
    return Recording(
        id=recording.id,
        sensor=recording.sensor,
        pass_id=recording.pass_id,
        path=recording.path,
        recorded=recording.recorded,
        calibration_id=row.calibrations[recording.sensor],
        rig_calibration_id=row.rig_calibration_id,
    )
