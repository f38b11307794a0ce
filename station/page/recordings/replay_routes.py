"""The addresses of measuring a recording once more, and of what came of it."""

from typing import Annotated

from fastapi import APIRouter, Form, Query, Request, Response
from fastapi.responses import JSONResponse

from station.api import By, Calibrator, PartsOf, Reader
from station.operations import cancel_job
from station.page.recordings.again import AgainForm, choices, order
from station.page.recordings.replay_view import compared_profiles, replay_page
from station.page.shell import ShellOf

router = APIRouter(prefix="/recordings/{recording_id}/replays")

_MeasurementId = Annotated[int | None, Query(ge=1, le=2**31 - 1)]


@router.get("/new")
def get_choices(
    recording_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Calibrator
) -> Response:
    """Return the form that a recording is measured once more by, a part of its page."""
    found = choices(parts.station, recording_id)
    return shell.page(request, "recordings/again.html", choices=found)


@router.post("")
def post_replay(
    recording_id: str,
    form: Annotated[AgainForm, Form()],
    shell: ShellOf,
    parts: PartsOf,
    _: Calibrator,
    by: By,
) -> Response:
    """Order it, and go to what comes of it."""
    view = order(parts.station, recording_id, form, by)
    address = f"/recordings/{recording_id}/replays/{view.row.id}"
    return shell.done(shell.texts.say("recordings.again.ordered"), to=address)


@router.get("/profiles")
def get_profiles(
    parts: PartsOf, _: Reader, before: _MeasurementId = None, after: _MeasurementId = None
) -> Response:
    """Return two profiles of a wheel on one grid, as JSON."""
    return JSONResponse(compared_profiles(parts.station, before, after))


@router.get("/{replay_id}")
def get_replay(
    recording_id: str, replay_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Reader
) -> Response:
    """Return the page of a replay."""
    shown = replay_page(parts.station, recording_id, replay_id)
    return shell.page(request, "recordings/replay.html", active="recordings", shown=shown)


@router.get("/{replay_id}/outcome")
def get_outcome(
    recording_id: str, replay_id: str, request: Request, shell: ShellOf, parts: PartsOf, _: Reader
) -> Response:
    """Return how far a replay is, or what came of it, a part of its page."""
    shown = replay_page(parts.station, recording_id, replay_id)
    return shell.page(request, "recordings/outcome.html", shown=shown)


@router.post("/{replay_id}/cancel")
def post_cancel(
    recording_id: str, replay_id: str, shell: ShellOf, parts: PartsOf, _: Calibrator, by: By
) -> Response:
    """Cancel it."""
    shown = replay_page(parts.station, recording_id, replay_id)
    cancel_job(parts.station, shown.job.id, by=by)
    return shell.done(shell.texts.say("recordings.replay.cancelled"), changed="second")
