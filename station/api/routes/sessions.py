"""Pictures for a calibration, taken one by one."""

from fastapi import APIRouter, Response

from calib import Target
from station.api.actors import By
from station.api.answers import SessionModel
from station.api.callers import Calibrator, Reader
from station.api.parts import PartsOf
from station.api.requests import IdInPath, SessionRequest
from station.operations import SessionOrder

router = APIRouter(prefix="/v1/calibration-sessions/{session_id}", tags=["calibration"])


@router.put("", responses={201: {"model": SessionModel}})
def put_session(
    session_id: IdInPath,
    body: SessionRequest,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    response: Response,
) -> SessionModel:
    """Ready a sensor, or a rig, for pictures on command.  A second time changes nothing."""
    view, new = parts.sessions.open(
        session_id,
        SessionOrder(
            target=Target.parse(body.target),
            sensor=body.sensor,
            rig=body.rig,
            targets={name: Target.parse(text) for name, text in body.targets.items()},
        ),
        by=by,
    )
    response.status_code = 201 if new else 200
    return SessionModel.of(view)


@router.post("/capture")
def capture_picture(session_id: IdInPath, parts: PartsOf, _: Calibrator) -> SessionModel:
    """Take one picture with each sensor; answers when they are recorded."""
    return SessionModel.of(parts.sessions.take_picture(session_id))


@router.post("/finish")
def finish_session(session_id: IdInPath, parts: PartsOf, _: Calibrator, by: By) -> SessionModel:
    """Close the recording of a session."""
    return SessionModel.of(parts.sessions.finish(session_id, by=by))


@router.get("")
def get_session(session_id: IdInPath, parts: PartsOf, _: Reader) -> SessionModel:
    """Return the state of a session and how many pictures it has."""
    return SessionModel.of(parts.sessions.view(session_id))
