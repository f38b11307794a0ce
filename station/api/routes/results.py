"""What was measured."""

from typing import Annotated

from fastapi import APIRouter, Header, Path, Query, Request, Response
from fastapi.responses import PlainTextResponse

from measure import Side
from station.api.callers import Reader
from station.api.measured_tables import (
    MEDIA_TYPE,
    Form,
    form_wanted,
    miniprof_text,
    table_of,
)
from station.api.parts import PartsOf
from station.api.remembered import from_the_store
from station.api.requests import CallersId, Limit, WheelsetId
from station.api.wheel_answers import MeasurementModel, MeasurementsPage
from station.settings import SensorId
from station.store import Measurement, the
from station.store.lists import measurements_page
from station.store.measured import places_of, profiles_of

router = APIRouter(prefix="/v1/measurements", tags=["measurements"])

_LARGEST_ID = 2**31 - 1  # what an integer column of PostgreSQL holds
_ID = Annotated[int, Path(ge=1, le=_LARGEST_ID)]
_TABLES = {media: {"schema": {"type": "string"}} for media in MEDIA_TYPE.values()}


@router.get("", response_model=MeasurementsPage, responses={200: {"content": _TABLES}})
@from_the_store
def list_measurements(
    request: Request,
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
    replay: Annotated[CallersId | None, Query(description="All that a replay came to.")] = None,
    profiles: Annotated[
        bool, Query(description="With their profiles, 40 kB each; not in tables.")
    ] = False,
    form: Annotated[
        Form | None,
        Query(alias="format", description="Absent: what Accept names. Tables have Link: next."),
    ] = None,
    accept: Annotated[str, Header(include_in_schema=False)] = "",
) -> MeasurementsPage | Response:
    """Return measurements in the order they were made, as JSON or as a table."""
    chosen = form_wanted(form, accept)
    with parts.station.store.look() as session:
        page = measurements_page(
            session,
            limit=limit,
            after=after,
            pass_id=pass_id,
            sensor=sensor,
            wheelset=wheelset,
            side=side,
            replay=replay,
        )
        places = places_of(session, page.rows)
        wanted = profiles and chosen is Form.JSON
        points = profiles_of(session, page.rows) if wanted else {}
    following = page.rows[-1].id if page.more else None
    if chosen is not Form.JSON:
        return _table(request, table_of(page.rows, places, chosen), chosen, following)
    return MeasurementsPage(
        measurements=[
            MeasurementModel.of(row, places.get(row.id), points.get(row.id)) for row in page.rows
        ],
        next=following,
    )


def _table(request: Request, content: bytes, form: Form, following: int | None) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="measurements.{form}"'}
    if following is not None:
        there = request.url.include_query_params(after=following, format=form.value)
        headers["Link"] = f'<{there.path}?{there.query}>; rel="next"'
    return Response(content, media_type=MEDIA_TYPE[form], headers=headers)


@router.get("/{measurement_id}")
@from_the_store
def get_measurement(measurement_id: _ID, parts: PartsOf, _: Reader) -> MeasurementModel:
    """Return one measurement with its profile."""
    with parts.station.store.look() as session:
        row = the(session, Measurement, measurement_id)
        place = places_of(session, [row]).get(row.id)
        return MeasurementModel.of(row, place, profiles_of(session, [row]).get(row.id))


@router.get("/{measurement_id}/miniprof", response_class=PlainTextResponse)
def get_miniprof(measurement_id: _ID, parts: PartsOf, _: Reader) -> PlainTextResponse:
    """Return the profile of one measurement as a MiniProf file."""
    with parts.station.store.look() as session:
        row = the(session, Measurement, measurement_id)
        place = places_of(session, [row]).get(row.id)
        text = miniprof_text(row, place, profiles_of(session, [row]).get(row.id))
    named = f'attachment; filename="measurement-{row.id}.whl"'
    return PlainTextResponse(text, headers={"Content-Disposition": named})
