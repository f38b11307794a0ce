"""The addresses of the page: the list of passes, and each pass with its train."""

from typing import Annotated
from zoneinfo import ZoneInfo

from fastapi import APIRouter, Query, Request, Response

from station.api import IdInPath, Parts, PartsOf, Reader, from_the_store
from station.page.passes.list_view import PassList, pass_list
from station.page.passes.search import Search
from station.page.passes.showing import Showing
from station.page.passes.train_view import TrainView, train_view
from station.page.shell import ShellOf
from station.store import PassState

router = APIRouter()
SearchAsked = Annotated[Search, Query()]


@router.get("/passes")
def get_passes(
    request: Request, parts: PartsOf, shell: ShellOf, _: Reader, search: SearchAsked
) -> Response:
    """Return the page with the passes that are looked for."""
    return shell.page(
        request,
        "passes/index.html",
        active="passes",
        search=search,
        states=tuple(PassState),
        found=_listed(parts, search),
    )


@router.get("/pass-list")
@from_the_store
def get_list(
    request: Request, parts: PartsOf, shell: ShellOf, _: Reader, search: SearchAsked
) -> Response:
    """Return the list alone, as it stands now."""
    return shell.page(request, "passes/list.html", search=search, found=_listed(parts, search))


@router.get("/passes/{pass_id}")
def get_pass(
    pass_id: IdInPath,
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    _: Reader,
    view: Showing = Showing.ROW,
) -> Response:
    """Return the page of a pass."""
    train = _train(parts, pass_id)
    return shell.page(request, "passes/pass.html", active="passes", train=train, view=view)


@router.get("/passes/{pass_id}/train")
@from_the_store
def get_train(
    pass_id: IdInPath,
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    _: Reader,
    view: Showing = Showing.ROW,
) -> Response:
    """Return what changes of a pass while it is recorded and measured."""
    return shell.page(request, "passes/train.html", train=_train(parts, pass_id), view=view)


def _listed(parts: Parts, search: Search) -> PassList:
    named = parts.station.settings.time_zone
    zone = None if named is None else ZoneInfo(named)
    with parts.station.store.look() as session:
        return pass_list(session, search, zone)


def _train(parts: Parts, pass_id: str) -> TrainView:
    view, found = parts.passes.view(pass_id), parts.passes.wheels(pass_id)
    with parts.station.store.look() as session:
        return train_view(session, view, found)
