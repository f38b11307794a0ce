"""What was measured."""

from typing import Annotated

from fastapi import APIRouter, Path, Query

from measure import Side
from station.api.callers import Reader
from station.api.parts import PartsOf
from station.api.requests import CallersId, Limit, WheelsetId
from station.api.wheel_answers import MeasurementModel, MeasurementsPage
from station.settings import SensorId
from station.store import Measurement, measurements_page, places_of, profiles_of, the

router = APIRouter(prefix="/v1/measurements", tags=["measurements"])

_LARGEST_ID = 2**31 - 1  # what an integer column of PostgreSQL holds


@router.get("")
def list_measurements(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    after: Annotated[int, Query(ge=0, le=_LARGEST_ID, description="`next` of a page.")] = 0,
    pass_id: Annotated[CallersId | None, Query(alias="pass")] = None,
    sensor: SensorId | None = None,
    wheelset: WheelsetId | None = None,
    side: Annotated[
        Side | None, Query(description="Of the train; with a wheelset, its own.")
    ] = None,
    profiles: Annotated[bool, Query(description="With their profiles, 40 kB each.")] = False,
) -> MeasurementsPage:
    """Return measurements in the order they were made."""
    with parts.station.store.look() as session:
        page = measurements_page(
            session,
            limit=limit,
            after=after,
            pass_id=pass_id,
            sensor=sensor,
            wheelset=wheelset,
            side=side,
        )
        places = places_of(session, page.rows)
        points = profiles_of(session, page.rows) if profiles else {}
    return MeasurementsPage(
        measurements=[
            MeasurementModel.of(row, places.get(row.id), points.get(row.id)) for row in page.rows
        ],
        next=page.rows[-1].id if page.more else None,
    )


@router.get("/{measurement_id}")
def get_measurement(
    measurement_id: Annotated[int, Path(ge=1, le=_LARGEST_ID)], parts: PartsOf, _: Reader
) -> MeasurementModel:
    """Return one measurement with its profile."""
    with parts.station.store.look() as session:
        row = the(session, Measurement, measurement_id)
        place = places_of(session, [row]).get(row.id)
        return MeasurementModel.of(row, place, profiles_of(session, [row]).get(row.id))
