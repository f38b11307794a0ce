"""Measuring recordings once more, with calibrations that the caller chooses."""

from typing import Annotated

from fastapi import APIRouter, Query, Response

from station.api.actors import By
from station.api.callers import Calibrator, Reader
from station.api.paging import Before, cursor_in
from station.api.parts import PartsOf
from station.api.replay_answers import ReplayModel, ReplaysPage
from station.api.requests import CallersId, IdInPath, Limit, ReplayRequest
from station.operations import ReplayOrder, order_replay, replay_view
from station.store import Replay, the
from station.store.lists import replays_page

router = APIRouter(prefix="/v1/replays", tags=["measurements"])

_RETRY_AFTER_S = "1"


@router.post("", status_code=202)
def post_replay(
    body: ReplayRequest, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> ReplayModel:
    """Have recordings measured once more; what was measured before stays."""
    view = order_replay(
        parts.station,
        ReplayOrder(
            recordings=body.recordings,
            pass_id=body.pass_id,
            calibrations=body.calibrations,
            rig_calibration=body.rig_calibration,
            reference=body.reference,
        ),
        by=by,
    )
    response.headers["Location"] = f"/v1/jobs/{view.job.id}"
    response.headers["Retry-After"] = _RETRY_AFTER_S
    return ReplayModel.of(view)


@router.get("")
def list_replays(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    pass_id: Annotated[CallersId | None, Query(alias="pass")] = None,
) -> ReplaysPage:
    """Return replays, the newest first."""
    with parts.station.store.look() as session:
        page = replays_page(session, limit=limit, before=cursor_in(before), pass_id=pass_id)
        views = [replay_view(session, row) for row in page.rows]
    return ReplaysPage.of(views, more=page.more)


@router.get("/{replay_id}")
def get_replay(replay_id: IdInPath, parts: PartsOf, _: Reader) -> ReplayModel:
    """Return what a replay is to measure, where it is, and what came of it."""
    with parts.station.store.look() as session:
        return ReplayModel.of(replay_view(session, the(session, Replay, replay_id)))
