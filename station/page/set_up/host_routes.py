"""The addresses of the host: software, settings file, examination."""

from fastapi import APIRouter, Request, Response

from station.api import Administrator, PartsOf, Reader
from station.doctor import Checkup
from station.errors import StateConflict
from station.page.set_up.frame import parts_for
from station.page.set_up.host_views import versions
from station.page.shell import ShellOf
from station.store import Store, pass_in_progress

router = APIRouter()


@router.get("/set-up/host")
def get_host(request: Request, parts: PartsOf, shell: ShellOf, caller: Reader) -> Response:
    """Return what runs here, where its settings are, and what the last examination found."""
    station = parts.station
    return shell.page(
        request,
        "set_up/host.html",
        active="set_up",
        parts_here=parts_for(caller),
        versions=versions(station.layout),
        file=station.settings.file,
        checkup=_checkup(request),
    )


@router.get("/set-up/host/findings")
def get_findings(request: Request, shell: ShellOf, _: Reader) -> Response:
    """Return what the last examination found, or how far one is."""
    return shell.page(request, "set_up/findings.html", checkup=_checkup(request))


@router.post("/set-up/host/examine")
def post_examine(request: Request, parts: PartsOf, shell: ShellOf, _: Administrator) -> Response:
    """Have the host examined, by another process."""
    _ensure_no_train_passes(parts.station.store)
    _checkup(request).begin()
    return shell.done(shell.texts.say("set_up.host.begun"), changed="findings")


def _checkup(request: Request) -> Checkup:
    checkup: Checkup = request.app.state.checkup
    return checkup


def _ensure_no_train_passes(store: Store) -> None:
    """Keep the trial of the disk away from frames that come by themselves.

    Raises
    ------
    StateConflict
        If a pass is being recorded.
    """
    with store.look() as session:
        running = pass_in_progress(session)
    if running is not None:
        raise StateConflict(
            f"pass {running.id} is {running.state}, and the examination writes to the same disk; "
            "wait until it has ended",
            state=running.state,
        )
