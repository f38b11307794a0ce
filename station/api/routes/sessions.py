"""Pictures for a calibration, taken one by one."""

from fastapi import APIRouter, Response

from calib import Target
from station.api.actors import By
from station.api.answers import SessionModel
from station.api.callers import Calibrator, Reader
from station.api.list_answers import SessionsPage
from station.api.paging import Before, cursor_in
from station.api.parts import PartsOf
from station.api.remembered import from_the_store
from station.api.requests import IdInPath, Limit, SessionRequest
from station.operations import SessionOrder
from station.settings import SensorId
from station.store.lists import recordings_by_session, sessions_page

router = APIRouter(prefix="/v1/calibration-sessions", tags=["calibration"])

_ONE = "/{session_id}"


@router.get("")
@from_the_store
def list_sessions(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    sensor: SensorId | None = None,
) -> SessionsPage:
    """Return calibration sessions, the newest first; of a sensor, those of its rig too."""
    with parts.station.store.look() as session:
        page = sessions_page(session, limit=limit, before=cursor_in(before), sensor=sensor)
        return SessionsPage.of(page, recordings_by_session(session, page.rows))


@router.put(_ONE, responses={201: {"model": SessionModel}})
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


@router.post(f"{_ONE}/capture")
def capture_picture(session_id: IdInPath, parts: PartsOf, _: Calibrator, by: By) -> SessionModel:
    """Take one picture with each sensor; answers when they are recorded."""
    name = parts.station.new_id()
    return SessionModel.of(parts.sessions.take_picture(session_id, name=name, by=by))


@router.post(f"{_ONE}/finish")
def finish_session(session_id: IdInPath, parts: PartsOf, _: Calibrator, by: By) -> SessionModel:
    """Close the recording of a session."""
    return SessionModel.of(parts.sessions.finish(session_id, by=by))


@router.get(_ONE)
@from_the_store
def get_session(session_id: IdInPath, parts: PartsOf, _: Reader) -> SessionModel:
    """Return the state of a session and how many pictures it has."""
    return SessionModel.of(parts.sessions.view(session_id))
