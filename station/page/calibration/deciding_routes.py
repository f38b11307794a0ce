"""Bringing a calibration into force or refusing it, and answering recalibrations that ask."""

from typing import Annotated, Literal

from fastapi import APIRouter, Form, Request, Response

from station.api import By, Calibrator, IdInPath, PartsOf, Reader
from station.operations import (
    activate_calibration,
    activate_rig_calibration,
    answer_recalibration,
    refuse_calibration,
    refuse_rig_calibration,
)
from station.page.going import go_to
from station.page.shell import ShellOf
from station.store import Calibration, Recalibration, RigCalibration, the

router = APIRouter()
_SENSOR, _RIG = "/calibrations/{calibration_id}", "/rig-calibrations/{calibration_id}"
Version = Annotated[int, Form(ge=0, le=2**31 - 1)]
"""Of what was in force when the person looked; 0 where nothing was."""
Why = Annotated[str, Form(min_length=1, max_length=500)]


@router.post(f"{_SENSOR}/activate")
def post_activate(
    calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, seen: Version
) -> Response:
    """Bring a sensor's calibration into force, unless somebody else changed it meanwhile."""
    with parts.station.store.look() as session:
        sensor = the(session, Calibration, calibration_id).sensor
    activate_calibration(parts.station, sensor, calibration_id, seen=seen or None, by=by)
    return go_to(f"/calibrations/{calibration_id}")


@router.post(f"{_RIG}/activate")
def post_activate_rig(
    calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, seen: Version
) -> Response:
    """Bring a rig's calibration into force, as a sensor's."""
    with parts.station.store.look() as session:
        rig = the(session, RigCalibration, calibration_id).rig
    activate_rig_calibration(parts.station, rig, calibration_id, seen=seen or None, by=by)
    return go_to(f"/rig-calibrations/{calibration_id}")


@router.post(f"{_SENSOR}/refuse")
def post_refuse(
    calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, why: Why
) -> Response:
    """Refuse a sensor's calibration."""
    refuse_calibration(parts.station, calibration_id, why=why, by=by)
    return go_to(f"/calibrations/{calibration_id}")


@router.post(f"{_RIG}/refuse")
def post_refuse_rig(
    calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, why: Why
) -> Response:
    """Refuse a rig's calibration."""
    refuse_rig_calibration(parts.station, calibration_id, why=why, by=by)
    return go_to(f"/rig-calibrations/{calibration_id}")


@router.get("/calibration/recalibrations/{recalibration_id}")
def get_recalibration(
    recalibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return what a recalibration found and decided, and what it asks."""
    with parts.station.store.look() as session:
        row = the(session, Recalibration, recalibration_id)
    return shell.page(request, "calibration/recalibration.html", active="calibration", row=row)


@router.post("/calibration/recalibrations/{recalibration_id}/answer")
def post_answer(
    recalibration_id: IdInPath,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    action: Annotated[Literal["activate", "refuse"], Form()],
    why: Why,
    seen: Annotated[int, Form(ge=1, le=2**31 - 1)],
) -> Response:
    """Answer a recalibration that asks."""
    bring = action == "activate"
    answer_recalibration(parts.station, recalibration_id, bring=bring, why=why, seen=seen, by=by)
    return go_to(f"/calibration/recalibrations/{recalibration_id}")
