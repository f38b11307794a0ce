"""The addresses of the page: sensors, limits, nightly job, storage."""

from typing import Annotated

from fastapi import APIRouter, Form, Request, Response

from station.api import By, Calibrator, PartsOf, Reader
from station.limits import limits_of
from station.operations import RecalibrationOrder, order_recalibration
from station.page.set_up import host_routes, key_routes, trail_routes
from station.page.set_up.frame import parts_for
from station.page.set_up.limit_views import limit_views
from station.page.set_up.night_views import night_view
from station.page.set_up.sensor_views import sensor_views
from station.page.set_up.storage_views import last_backup, usage_of
from station.page.set_up.told import settings_in
from station.page.shell import ShellOf

router = APIRouter()
for _each in (host_routes, key_routes, trail_routes):
    router.include_router(_each.router)


@router.get("/set-up")
def get_page(request: Request, parts: PartsOf, shell: ShellOf, caller: Reader) -> Response:
    """Return the sensors, as they are set and as their cameras are."""
    statuses = parts.lookout.look().statuses
    return shell.page(
        request,
        "set_up/sensors.html",
        active="set_up",
        parts_here=parts_for(caller),
        sensors=sensor_views(parts.station.settings, statuses),
    )


@router.get("/set-up/limits")
def get_limits(request: Request, parts: PartsOf, shell: ShellOf, caller: Reader) -> Response:
    """Return the limits in force."""
    settings = parts.station.settings.limits
    limits = limits_of(settings)
    return shell.page(
        request,
        "set_up/limits.html",
        active="set_up",
        parts_here=parts_for(caller),
        regime=limits.regime,
        preset=settings.preset,
        limits=limit_views(limits, settings),
    )


@router.get("/set-up/nightly")
def get_nightly(request: Request, parts: PartsOf, shell: ShellOf, caller: Reader) -> Response:
    """Return the nightly job."""
    station = parts.station
    with station.store.look() as session:
        job = night_view(session, station.settings, station.now())
    return shell.page(
        request,
        "set_up/nightly.html",
        active="set_up",
        parts_here=parts_for(caller),
        job=job,
        worker_ready=parts.worker_ready(),
    )


@router.get("/set-up/nightly/nights")
def get_nights(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return what came of the last nights, and of those that somebody ordered."""
    station = parts.station
    with station.store.look() as session:
        job = night_view(session, station.settings, station.now())
    return shell.page(request, "set_up/nights.html", job=job)


@router.post("/set-up/nightly/order")
def post_order(
    parts: PartsOf, shell: ShellOf, _: Calibrator, by: By, sensor: Annotated[str, Form()]
) -> Response:
    """Have a sensor recalibrated now."""
    order_recalibration(parts.station, RecalibrationOrder(sensor), by=by)
    return shell.done(shell.texts.say("set_up.nightly.ordered", sensor=sensor), changed="nights")


@router.get("/set-up/storage")
def get_storage(request: Request, parts: PartsOf, shell: ShellOf, caller: Reader) -> Response:
    """Return what the settings say of the disk, and the last backup."""
    station = parts.station
    return shell.page(
        request,
        "set_up/storage.html",
        active="set_up",
        parts_here=parts_for(caller),
        settings=settings_in(station.settings.storage, "storage"),
        backup=last_backup(station.layout),
    )


@router.get("/set-up/storage/usage")
def get_usage(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return how full the disk is; apart, as many files are looked at."""
    try:
        usage = usage_of(parts.station)
    except OSError:
        usage = None
    return shell.page(request, "set_up/usage.html", usage=usage)
