"""The addresses of the page."""

from typing import Annotated

from fastapi import APIRouter, Form, Request, Response

from station.api import (
    By,
    CallersId,
    Count,
    Operator,
    PartsOf,
    Reader,
    TrainName,
    for_a_moment,
    from_the_store,
)
from station.operations import trigger_pass
from station.page.now.passing import last_pass, suggested_id
from station.page.now.views import now_view
from station.page.shell import ShellOf

router = APIRouter()

_CHANGED = "pass-changed"
"""The event on the page's body after which the buttons are others."""


@router.get("/now")
def get_page(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return the page."""
    station = parts.station
    with station.store.look() as session:
        last = last_pass(session)
    return shell.page(
        request,
        "now/index.html",
        active="now",
        view=now_view(parts),
        last=last,
        suggested=suggested_id(station.now()),
    )


@router.get("/now/live")
@for_a_moment
def get_live(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return the parts of the page that change by themselves; each finds its place by its id."""
    return shell.packed(request, "now/live.html", view=now_view(parts))


@router.get("/now/last")
@from_the_store
def get_last(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return the pass that ended last."""
    with parts.station.store.look() as session:
        return shell.page(request, "now/last.html", last=last_pass(session))


@router.get("/now/desk")
def get_desk(request: Request, parts: PartsOf, shell: ShellOf, _: Reader) -> Response:
    """Return the buttons for the next pass, or for the one in progress."""
    suggested = suggested_id(parts.station.now())
    return shell.page(request, "now/desk.html", view=now_view(parts), suggested=suggested)


@router.post("/now/arm")
def post_arm(
    parts: PartsOf,
    shell: ShellOf,
    _: Operator,
    by: By,
    pass_id: Annotated[CallersId, Form()],
    train: Annotated[TrainName | None, Form()] = None,
) -> Response:
    """Arm every sensor for a train."""
    opened = parts.passes.open(pass_id, train=train, by=by)
    said = "now.said.armed" if opened[1] else "now.said.armed_before"
    return shell.done(shell.texts.say(said, id=pass_id), changed=_CHANGED)


@router.post("/now/finish")
def post_finish(
    parts: PartsOf,
    shell: ShellOf,
    _: Operator,
    by: By,
    pass_id: Annotated[CallersId, Form()],
    axles: Annotated[Count | None, Form()] = None,
) -> Response:
    """End the recording of a pass and have it measured."""
    view = parts.passes.finish(pass_id, axles=axles, triggers={}, by=by)
    state = shell.texts.say(f"now.pass_state.{view.row.state}")
    said = shell.texts.say("now.said.finished", id=pass_id, state=state.lower())
    return shell.done(said, changed=_CHANGED)


@router.post("/now/trigger")
def post_trigger(parts: PartsOf, shell: ShellOf, _: Operator, by: By) -> Response:
    """Take a frame of the pass in progress, by every sensor that waits for a command."""
    frames = trigger_pass(parts.station, by=by)
    taken = ", ".join(f"{sensor} {frame}" for sensor, frame in frames.items())
    return shell.done(shell.texts.say("now.said.triggered", frames=taken))
