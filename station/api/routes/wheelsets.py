"""How wheels change from pass to pass."""

from typing import Annotated

from fastapi import APIRouter, Query

from station.api.callers import Reader
from station.api.parts import PartsOf
from station.api.remembered import from_the_store
from station.api.requests import WheelsetInPath
from station.api.train_answers import WheelsetTrendModel
from station.limits import limits_of
from station.trains import wheelset_trend

router = APIRouter(prefix="/v1/wheelsets/{wheelset_id}", tags=["measurements"])


@router.get("/trend")
@from_the_store
def get_trend(
    wheelset_id: WheelsetInPath,
    parts: PartsOf,
    _: Reader,
    passes: Annotated[int, Query(ge=1, le=500, description="The last so many passes.")] = 100,
) -> WheelsetTrendModel:
    """Return the values of a wheelset's last passes, its rates of wear, and its jumps."""
    limits = limits_of(parts.station.settings.limits)
    with parts.station.store.look() as session:
        found = wheelset_trend(session, wheelset_id, limits, most=passes)
    return WheelsetTrendModel.model_validate(found)
