"""Measuring a recording once more: what there is to choose from, and the order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, get_args

from pydantic import BaseModel, ConfigDict, StringConstraints

from station.operations import ReferenceName, ReplayOrder, ReplayView, Station, order_replay
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    Recording,
    active,
    calibrations_page,
    the,
)

_MOST = 200
REFERENCES: tuple[str, ...] = get_args(ReferenceName)


class AgainForm(BaseModel):
    """What the form sends."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    calibration: Annotated[str, StringConstraints(min_length=1, max_length=128)]
    reference: ReferenceName


@dataclass(frozen=True, slots=True)
class Choices:
    """What a recording can be measured with."""

    recording: Recording
    calibrations: Sequence[Calibration]
    """The ready ones of its sensor, the newest first, without their documents."""
    in_force: str | None
    """The one in force now."""
    references: tuple[str, ...]
    reference: str
    """The station's."""


def choices(station: Station, recording_id: str) -> Choices:
    """Return what a recording can be measured with; NotFound where there is no such one."""
    with station.store.look() as session:
        row = the(session, Recording, recording_id)
        found = calibrations_page(session, limit=_MOST, sensor=row.sensor).rows
        present = active(session, row.sensor)
    return Choices(
        recording=row,
        calibrations=[each for each in found if each.state is CalibrationState.READY],
        in_force=None if present is None else present.calibration_id,
        references=REFERENCES,
        reference=station.settings.reference,
    )


def order(station: Station, recording_id: str, form: AgainForm, by: Actor) -> ReplayView:
    """Order the measuring; `order_replay` says what it refuses."""
    with station.store.look() as session:
        sensor = the(session, Recording, recording_id).sensor
    wanted = ReplayOrder(
        recordings=[recording_id],
        calibrations={sensor: form.calibration},
        reference=form.reference,
    )
    return order_replay(station, wanted, by=by)
