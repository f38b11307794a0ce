"""The addresses of keys and of who is logged in with them: for administrators alone."""

from datetime import datetime, timedelta
from typing import Annotated

from fastapi import APIRouter, Form, Path, Request, Response

from station.api import Administrator, By, PartsOf
from station.operations import Keys, key_id_of
from station.page.set_up.frame import parts_for
from station.page.set_up.key_views import key_views
from station.page.shell import ShellOf
from station.store.callers import Scope

router = APIRouter(prefix="/set-up")

_Days = Annotated[float | None, Form(ge=0.01, le=3650.0)]
_KeyId = Annotated[str, Path(pattern=r"^[0-9a-f]{8}$")]
_LoginName = Annotated[str, Path(pattern=r"^[0-9a-f]{16}$")]


@router.get("/keys")
def get_keys(request: Request, parts: PartsOf, shell: ShellOf, caller: Administrator) -> Response:
    """Return the page of the keys."""
    return shell.page(
        request,
        "set_up/keys.html",
        active="set_up",
        parts_here=parts_for(caller),
        scopes=list(Scope),
    )


@router.get("/keys/list")
def get_key_list(
    request: Request, parts: PartsOf, shell: ShellOf, caller: Administrator, by: By
) -> Response:
    """Return all keys that were ever made."""
    now = parts.station.now()
    keys = Keys(parts.station.store, by, now).list()
    return shell.page(request, "set_up/key_list.html", keys=key_views(keys, at=now, caller=caller))


@router.post("/keys")
def post_key(
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    _: Administrator,
    by: By,
    name: Annotated[str, Form(max_length=64)],
    scopes: Annotated[list[Scope] | None, Form()] = None,
    days: _Days = None,
) -> Response:
    """Make a key, and show it this once."""
    now = parts.station.now()
    text = Keys(parts.station.store, by, now).create(name.strip(), scopes or [], _after(now, days))
    return _shown_once(request, shell, text, name.strip())


@router.post("/keys/{key_id}/rotate")
def post_rotation(
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    _: Administrator,
    by: By,
    key_id: _KeyId,
    keep_h: Annotated[float, Form(ge=0.0, le=2160.0)],
    days: _Days = None,
) -> Response:
    """Make a key in place of another, and show it this once."""
    now = parts.station.now()
    keys = Keys(parts.station.store, by, now)
    text = keys.rotate(key_id, timedelta(hours=keep_h), _after(now, days))
    name = next(key.name for key in keys.list() if key.id == key_id)
    return _shown_once(request, shell, text, name)


@router.post("/keys/{key_id}/revoke")
def post_revocation(
    parts: PartsOf, shell: ShellOf, _: Administrator, by: By, key_id: _KeyId
) -> Response:
    """Take a key back; who is logged in with it is let out."""
    key = Keys(parts.station.store, by, parts.station.now()).revoke(key_id)
    return shell.done(shell.texts.say("set_up.keys.revoked", name=key.name), changed="keys")


@router.get("/logins")
def get_logins(request: Request, parts: PartsOf, shell: ShellOf, _: Administrator) -> Response:
    """Return who is logged in."""
    own = request.state.logged_in
    return shell.page(
        request,
        "set_up/logins.html",
        logins=parts.logins.all(),
        own=None if own is None else own.name,
    )


@router.post("/logins/{name}/end")
def post_login_end(
    parts: PartsOf, shell: ShellOf, _: Administrator, by: By, name: _LoginName
) -> Response:
    """Let a browser out."""
    parts.logins.end_named(name, by=by)
    return shell.done(shell.texts.say("set_up.logins.ended"), changed="keys")


def _shown_once(request: Request, shell: ShellOf, text: str, name: str) -> Response:
    page = shell.page(
        request, "set_up/new_key.html", status=201, text=text, key_id=key_id_of(text), name=name
    )
    page.headers["HX-Trigger"] = "keys"
    return page


def _after(now: datetime, days: float | None) -> datetime | None:
    return None if days is None else now + timedelta(days=days)
