"""Measuring a recording once more: what there is to choose from, and the order.

The recording of a rig's sensor is measured with the others of its pass, or alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Self, get_args

from pydantic import BaseModel, ConfigDict, StringConstraints, model_validator
from sqlalchemy.orm import Session

from station.errors import InputUnusable
from station.operations import ReferenceName, ReplayOrder, ReplayView, Station, order_replay
from station.settings import RigSettings
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    Pass,
    Recording,
    RigCalibration,
    active,
    active_rig,
    recordings_of,
    the,
)
from station.store.lists import calibrations_page, rig_calibrations_page

_MOST = 200
REFERENCES: tuple[str, ...] = get_args(ReferenceName)
_Id = Annotated[str, StringConstraints(min_length=1, max_length=128)]


class AgainForm(BaseModel):
    """What the form sends: the calibration of the sensor, or that of its rig."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    calibration: _Id | None = None
    rig_calibration: _Id | None = None
    reference: ReferenceName

    @model_validator(mode="after")
    def _one_of_them(self) -> Self:
        if (self.calibration is None) == (self.rig_calibration is None):
            raise ValueError("give the calibration of the sensor, or that of its rig")
        return self


@dataclass(frozen=True, slots=True)
class RigChoices:
    """What a pass can be measured with by one of the rigs that a sensor is of."""

    rig: str
    sensors: tuple[str, ...]
    """Those of which the pass has a recording that holds frames."""
    calibrations: Sequence[RigCalibration]
    """The ready ones, the newest first, without their documents."""
    in_force: str | None


@dataclass(frozen=True, slots=True)
class Choices:
    """What a recording can be measured with."""

    recording: Recording
    calibrations: Sequence[Calibration]
    """The ready ones of its sensor, the newest first, without their documents."""
    in_force: str | None
    """The one in force now."""
    rigs: tuple[RigChoices, ...]
    """None of a recording that is of no pass: whatever it was taken together with, nobody knows."""
    references: tuple[str, ...]
    reference: str
    """The station's."""


def choices(station: Station, recording_id: str) -> Choices:
    """Return what a recording can be measured with; NotFound where there is no such one."""
    with station.store.look() as session:
        row = the(session, Recording, recording_id)
        found = calibrations_page(session, limit=_MOST, sensor=row.sensor).rows
        present = active(session, row.sensor)
        rigs = tuple(_of_rig(session, row, rig) for rig in _rigs(station, row))
    return Choices(
        recording=row,
        calibrations=[each for each in found if each.state is CalibrationState.READY],
        in_force=None if present is None else present.calibration_id,
        rigs=rigs,
        references=REFERENCES,
        reference=station.settings.reference,
    )


def _rigs(station: Station, row: Recording) -> list[RigSettings]:
    if row.pass_id is None:
        return []
    return [rig for rig in station.settings.rigs if row.sensor in rig.sensors]


def _of_rig(session: Session, row: Recording, rig: RigSettings) -> RigChoices:
    found = rig_calibrations_page(session, limit=_MOST, rig=rig.id).rows
    present = active_rig(session, rig.id)
    return RigChoices(
        rig=rig.id,
        sensors=tuple(each.sensor for each in _together(session, row, rig) if each.recorded),
        calibrations=[each for each in found if each.state is CalibrationState.READY],
        in_force=None if present is None else present.rig_calibration_id,
    )


def _together(session: Session, row: Recording, rig: RigSettings) -> list[Recording]:
    """Return the recordings of a rig's sensors of the pass that a recording is of."""
    owner = the(session, Pass, row.pass_id or "")
    return [each for each in recordings_of(session, owner) if each.sensor in rig.sensors]


def order(station: Station, recording_id: str, form: AgainForm, by: Actor) -> ReplayView:
    """Order the measuring.

    Raises
    ------
    NotFound
        If there is no such recording or calibration.
    InputUnusable
        If the calibration is of a rig that the recording's sensor is not in, or the recording of
        no pass.
    StateConflict
        As of `order_replay`; also where what another sensor of the rig recorded has been deleted:
        without it the wheels would be others, not the same ones measured again.
    """
    if form.rig_calibration is not None:
        return order_replay(station, _on_rig(station, recording_id, form), by=by)
    with station.store.look() as session:
        sensor = the(session, Recording, recording_id).sensor
    alone = ReplayOrder(
        recordings=[recording_id],
        calibrations={sensor: form.calibration or ""},
        reference=form.reference,
    )
    return order_replay(station, alone, by=by)


def _on_rig(station: Station, recording_id: str, form: AgainForm) -> ReplayOrder:
    with station.store.look() as session:
        row = the(session, Recording, recording_id)
        wanted = the(session, RigCalibration, form.rig_calibration or "").rig
        rig = next((each for each in _rigs(station, row) if each.id == wanted), None)
        if rig is None:
            raise InputUnusable(
                f"recording {row.id} is of no pass that rig {wanted} saw with sensor {row.sensor}; "
                "measure it alone, with a calibration of its sensor"
            )
        names = [each.id for each in _together(session, row, rig)]
    return ReplayOrder(
        recordings=names, rig_calibration=form.rig_calibration, reference=form.reference
    )
