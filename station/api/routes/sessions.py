"""Pictures for a calibration, taken one by one."""

from fastapi import APIRouter, Response

from calib import Target
from station.api.answers import SessionModel
from station.api.callers import Calibrator, Reader
from station.api.parts import PartsOf
from station.api.requests import IdInPath, SessionRequest

router = APIRouter(prefix="/v1/calibration-sessions/{session_id}", tags=["calibration"])


@router.put("", responses={201: {"model": SessionModel}})
def put_session(
    session_id: IdInPath,
    body: SessionRequest,
    parts: PartsOf,
    _: Calibrator,
    response: Response,
) -> SessionModel:
    """Ready a sensor for pictures on command.  A second time changes nothing."""
    view, new = parts.sessions.open(
        session_id, sensor=body.sensor, target=Target.parse(body.target)
    )
    response.status_code = 201 if new else 200
    return SessionModel.of(view)


@router.post("/capture")
def capture_picture(session_id: IdInPath, parts: PartsOf, _: Calibrator) -> SessionModel:
    """Take one picture; answers when it is recorded."""
    return SessionModel.of(parts.sessions.take_picture(session_id))


@router.post("/finish")
def finish_session(session_id: IdInPath, parts: PartsOf, _: Calibrator) -> SessionModel:
    """Close the recording of a session."""
    return SessionModel.of(parts.sessions.finish(session_id))


@router.get("")
def get_session(session_id: IdInPath, parts: PartsOf, _: Reader) -> SessionModel:
    """Return the state of a session and how many pictures it has."""
    return SessionModel.of(parts.sessions.view(session_id))
