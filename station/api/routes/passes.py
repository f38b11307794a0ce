"""What the trackside controller calls."""

from fastapi import APIRouter, Response

from station.api.actors import By
from station.api.answers import PassModel
from station.api.callers import Operator, Reader
from station.api.parts import PartsOf
from station.api.requests import FinishRequest, IdInPath, PassRequest
from station.api.wheel_answers import WheelsModel
from station.trains import Named

router = APIRouter(prefix="/v1/passes/{pass_id}", tags=["passes"])


@router.put("", responses={201: {"model": PassModel}})
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


@router.post("/finish")
def finish_pass(
    pass_id: IdInPath, body: FinishRequest, parts: PartsOf, _: Operator, by: By
) -> PassModel:
    """Close, hold the frames against the count, have them measured: the train has gone."""
    view = parts.passes.finish(
        pass_id,
        axles=body.axles,
        triggers=body.triggers,
        by=by,
        consist=body.named(Named.GONE),
    )
    return PassModel.of(view)


@router.get("")
def get_pass(pass_id: IdInPath, parts: PartsOf, _: Reader) -> PassModel:
    """Return the state of a pass and how its frames add up."""
    return PassModel.of(parts.passes.view(pass_id))


@router.get("/wheels")
def get_wheels(pass_id: IdInPath, parts: PartsOf, _: Reader) -> WheelsModel:
    """Return the wheels of a pass, those measured so far, and its axles once all are."""
    return WheelsModel.of(parts.passes.wheels(pass_id))
