"""The addresses of one wheel, and of a wheelset over its passes."""

from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import JSONResponse

from measure import Quantity
from station.api import IdInPath, PartsOf, Reader, from_the_store
from station.documents import WheelDocument
from station.limits import limits_of
from station.page.passes.profile_drawing import profile_drawing, reference_named
from station.page.passes.source_view import source_frames
from station.page.passes.trend_view import Trended
from station.page.passes.wheel_view import one_wheel
from station.page.shell import ShellOf
from station.store import Measurement, the
from station.store.measured import profiles_of
from station.trains import wheelset_trend

router = APIRouter()
_LARGEST_ID = 2**31 - 1  # what an integer column of PostgreSQL holds
MeasurementId = Annotated[int, Path(ge=1, le=_LARGEST_ID)]
_MOST_PASSES = 200
_TRENDED = (
    Quantity.TREAD_WEAR,
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_GRADIENT_QR,
    Quantity.TREAD_WEAR_AT_70,
    Quantity.TREAD_WEAR_MAX,
    Quantity.HOLLOW_DEPTH,
    Quantity.DIAMETER,
)
"""What a person chooses from, the wear first."""


@router.get("/wheels/{measurement_id}")
def get_wheel(
    measurement_id: MeasurementId, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the page of a measured wheel."""
    limits = limits_of(parts.station.settings.limits)
    with parts.station.store.look() as session:
        wheel = one_wheel(session, measurement_id, limits)
    return shell.page(
        request, "passes/wheel.html", active="passes", wheel=wheel, quantities=_TRENDED
    )


@router.get("/wheels/{measurement_id}/drawing")
@from_the_store
def get_drawing(measurement_id: MeasurementId, parts: PartsOf, _: Reader) -> Response:
    """Return the wheel's profile as it is drawn."""
    with parts.station.store.look() as session:
        row = the(session, Measurement, measurement_id)
        profile = profiles_of(session, [row]).get(row.id)
    wheel = WheelDocument.model_validate({**row.wheel, "profile": profile})
    reference = reference_named(row.reference, parts.station.settings.reference)
    return JSONResponse(profile_drawing(row.id, wheel, reference, row.reference))


@router.get("/wheels/{measurement_id}/source")
def get_source(
    measurement_id: MeasurementId, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the frames that the wheel was measured from."""
    frames = source_frames(parts.station, measurement_id)
    return shell.page(request, "passes/source.html", frames=frames)


@router.get("/wheelsets/{wheelset}/trend/{quantity}")
@from_the_store
def get_trend(
    wheelset: IdInPath, quantity: Quantity, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return how a quantity of a wheelset changed, as a chart takes it."""
    limits = limits_of(parts.station.settings.limits)
    with parts.station.store.look() as session:
        trend = wheelset_trend(session, wheelset, limits, most=_MOST_PASSES)
    return JSONResponse(Trended.of(trend, quantity, limits).chart(shell.texts))
