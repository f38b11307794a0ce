"""Adding the pages to the app of the API."""

from functools import partial

from fastapi import FastAPI

from station.api import Parts
from station.doctor import Checkup, Patient, examine_apart
from station.page import calibration, login, now, passes, recordings, set_up, static
from station.page.people import AnswersForPeople
from station.page.shell import Shell

_ROUTERS = (
    static.router,
    login.router,
    now.router,
    passes.router,
    calibration.router,
    recordings.router,
    set_up.router,
)


def add_pages(app: FastAPI) -> None:
    """Serve the pages beside the API of an app made by `build_app`."""
    parts: Parts = app.state.parts
    station = parts.station
    app.state.shell = shell = Shell.of(station.settings)
    app.state.checkup = Checkup(partial(examine_apart, Patient.of(station.settings)), station.now)
    for router in _ROUTERS:
        # The contract is of what programs call; a page may change with every version.
        app.include_router(router, include_in_schema=False)
    app.add_middleware(AnswersForPeople, shell=shell)
