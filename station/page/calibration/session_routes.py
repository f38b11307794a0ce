"""A guided session: opening it, taking pictures, what is still wanted, ending it, solving."""

from typing import Annotated, Literal

from fastapi import APIRouter, Form, Request, Response
from fastapi.responses import JSONResponse

from calib import Target
from station.api import By, Calibrator, CallersId, IdInPath, PartsOf, Reader
from station.documents import BOARD_SIGMA_MM
from station.operations import (
    CalibrationOrder,
    MethodName,
    RigCalibrationOrder,
    order_calibration,
    order_rig_calibration,
)
from station.page.calibration.opening import TargetForm, order_of
from station.page.calibration.session import guidance_told, session_shown
from station.page.going import go_to
from station.page.shell import ShellOf

router = APIRouter(prefix="/calibration/sessions")
_ONE = "/{session_id}"


@router.post("")
def post_session(
    parts: PartsOf,
    _: Calibrator,
    by: By,
    name: Annotated[CallersId, Form()],
    of: Annotated[str, Form(max_length=80)],
    rows: Annotated[int, Form(ge=2, le=200)],
    cols: Annotated[int, Form(ge=2, le=200)],
    pitch_mm: Annotated[float, Form(gt=0.0, le=1000.0)],
    kind: Annotated[Literal["dots", "chessboard"], Form()] = "dots",
    dark: Annotated[bool, Form()] = False,
    diameter_mm: Annotated[float | None, Form(gt=0.0, le=1000.0)] = None,
) -> Response:
    """Open a session, and go there."""
    target = TargetForm(kind, rows, cols, pitch_mm, dark, diameter_mm).target()
    parts.sessions.open(name, order_of(of, target), by=by)
    return go_to(f"/calibration/sessions/{name}")


@router.get(_ONE)
def get_session(
    session_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the page of a session."""
    view = parts.sessions.view(session_id)
    shown = session_shown(parts.station, view)
    return shell.page(request, "calibration/session.html", active="calibration", shown=shown)


@router.get(f"{_ONE}/guidance")
def get_guidance(session_id: IdInPath, parts: PartsOf, _: Reader) -> Response:
    """Return what is found in the pictures so far, and what comes next, by sensor."""
    view = parts.sessions.view(session_id)
    told = parts.guiding.guidance(session_id)
    return JSONResponse(guidance_told(session_shown(parts.station, view), told))


@router.post(f"{_ONE}/capture")
def post_capture(
    session_id: IdInPath, parts: PartsOf, shell: ShellOf, _: Calibrator, by: By
) -> Response:
    """Take one picture with each sensor."""
    view = parts.sessions.take_picture(session_id, name=parts.station.new_id(), by=by)
    said = shell.texts.say("calibration.session.taken", count=view.row.pictures)
    return shell.done(said, changed="pictures")


@router.post(f"{_ONE}/finish")
def post_finish(session_id: IdInPath, parts: PartsOf, _: Calibrator, by: By) -> Response:
    """Close a session."""
    parts.sessions.finish(session_id, by=by)
    return go_to(f"/calibration/sessions/{session_id}")


@router.post(f"{_ONE}/solve")
def post_solve(
    session_id: IdInPath,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    sensor: Annotated[CallersId, Form()],
    method: Annotated[MethodName, Form()] = "joint",
) -> Response:
    """Have a sensor's calibration solved from a session, and go to its report."""
    order = CalibrationOrder(sensor, method, session_id, (), None, ())
    row, _job = order_calibration(parts.station, order, by=by)
    return go_to(f"/calibrations/{row.id}")


@router.post(f"{_ONE}/solve-rig")
def post_solve_rig(
    session_id: IdInPath,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    rig: Annotated[CallersId, Form()],
    boards: Annotated[Literal["same", "own"], Form()] = "own",
    board_sigma_mm: Annotated[float, Form(ge=0.0, le=1.0)] = BOARD_SIGMA_MM,
) -> Response:
    """Have a rig's calibration solved from a session, and go to its report."""
    targets: dict[str, Target] = {}
    order = RigCalibrationOrder(
        rig, session_id, {}, None, targets, boards == "same", board_sigma_mm
    )
    row, _job = order_rig_calibration(parts.station, order, by=by)
    return go_to(f"/rig-calibrations/{row.id}")
