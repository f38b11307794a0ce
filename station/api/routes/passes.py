"""What the trackside controller calls."""

from typing import Annotated

from fastapi import APIRouter, Query, Response

from station.api.actors import By
from station.api.answers import PassModel
from station.api.callers import Operator, Reader
from station.api.list_answers import PassesPage
from station.api.paging import Before, Since, Until, cursor_in, span_of
from station.api.parts import PartsOf
from station.api.remembered import from_the_store
from station.api.requests import (
    FinishRequest,
    IdInPath,
    Limit,
    PassRequest,
    TrainName,
    WheelsetId,
)
from station.api.wheel_answers import WheelsModel
from station.store import PassState
from station.store.lists import passes_page, recordings_by_pass
from station.trains import Named

router = APIRouter(prefix="/v1/passes", tags=["passes"])

_ONE = "/{pass_id}"


@router.get("")
@from_the_store
def list_passes(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    state: PassState | None = None,
    train: TrainName | None = None,
    wheelset: Annotated[
        WheelsetId | None, Query(description="One that was placed in the pass.")
    ] = None,
    since: Since = None,
    until: Until = None,
) -> PassesPage:
    """Return passes, the newest first."""
    with parts.station.store.look() as session:
        page = passes_page(
            session,
            limit=limit,
            before=cursor_in(before),
            span=span_of(since, until),
            state=state,
            train=train,
            wheelset=wheelset,
        )
        return PassesPage.of(page, recordings_by_pass(session, page.rows))


@router.put(_ONE, responses={201: {"model": PassModel}})
def put_pass(
    pass_id: IdInPath,
    body: PassRequest,
    parts: PartsOf,
    _: Operator,
    by: By,
    response: Response,
) -> PassModel:
    """Arm every sensor and record: a train comes.  A second time changes nothing."""
    view, new = parts.passes.open(
        pass_id, train=body.train, by=by, consist=body.named(Named.COMING)
    )
    response.status_code = 201 if new else 200
    return PassModel.of(view)


@router.post(f"{_ONE}/finish")
def finish_pass(
    pass_id: IdInPath, body: FinishRequest, parts: PartsOf, _: Operator, by: By
) -> PassModel:
    """Close, hold the frames against the count, have them measured: the train has gone.

    Of a pass that has ended by itself it brings in what was counted.  The same again changes
    nothing; other counts are refused.
    """
    view = parts.passes.finish(
        pass_id,
        axles=body.axles,
        triggers=body.triggers,
        by=by,
        consist=body.named(Named.GONE),
    )
    return PassModel.of(view)


@router.get(_ONE)
@from_the_store
def get_pass(pass_id: IdInPath, parts: PartsOf, _: Reader) -> PassModel:
    """Return the state of a pass and how its frames add up."""
    return PassModel.of(parts.passes.view(pass_id))


@router.get(f"{_ONE}/wheels")
@from_the_store
def get_wheels(pass_id: IdInPath, parts: PartsOf, _: Reader) -> WheelsModel:
    """Return the wheels of a pass, those measured so far, and its axles once all are."""
    return WheelsModel.of(parts.passes.wheels(pass_id))
