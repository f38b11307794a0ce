"""The page as it opens."""

from fastapi import APIRouter, Request, Response

from station.api import PartsOf, Reader, for_a_moment
from station.page.calibration.made import made
from station.page.calibration.opening import choices_of, suggested_name
from station.page.calibration.overview import overview_of
from station.page.shell import ShellOf

router = APIRouter()


@router.get("/calibration")
def get_page(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return the page."""
    with parts.station.store.look() as session:
        overview, history = overview_of(session, parts.station), made(session)
    return shell.page(
        request,
        "calibration/index.html",
        active="calibration",
        overview=overview,
        made=history,
        choices=choices_of(parts.station.settings),
        suggested=suggested_name(parts.station.now()),
    )


@router.get("/calibration/state")
@for_a_moment
def get_state(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return what changes by itself: what is in force, what waits, what is worked on."""
    with parts.station.store.look() as session:
        overview = overview_of(session, parts.station)
    return shell.page(request, "calibration/state.html", overview=overview)


@router.get("/calibration/made")
@for_a_moment
def get_made(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return all calibrations that were made lately."""
    with parts.station.store.look() as session:
        history = made(session)
    return shell.page(request, "calibration/made.html", made=history)
