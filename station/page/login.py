"""Coming in by a key, and going out."""

from typing import Annotated, Final
from urllib.parse import urlsplit

from fastapi import APIRouter, Form, Request, Response
from fastapi.responses import RedirectResponse

from station.api import By, PartsOf, Reader, TooManyBadKeys, cookie_in, status_of
from station.errors import KeyRefused
from station.page.shell import Shell, ShellOf

router = APIRouter()
_FIRST: Final = "/now"
_LONGEST_KEY: Final = 512


@router.get("/")
async def get_first(_: Reader) -> Response:
    """Go to the first page."""
    return RedirectResponse(_FIRST, status_code=303)


@router.get("/login")
async def get_login(request: Request, shell: ShellOf, next: str = _FIRST) -> Response:  # noqa: A002  the parameter's name on the wire
    """Return the page that asks for a key."""
    return shell.page(request, "shell/login.html", leads_to=next, refused=None, active=None)


@router.post("/login")
def post_login(
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    key: Annotated[str, Form(max_length=_LONGEST_KEY)],
    leads_to: Annotated[str, Form()] = _FIRST,
) -> Response:
    """Let a browser in, and go on to where it wanted to."""
    if _from_elsewhere(request):
        # Somebody else's page must not log its visitors in under a key of its own.
        raise KeyRefused("the login came from a page of another host; log in here")
    address = request.client.host if request.client else "nowhere"
    try:
        logged_in = parts.logins.begin(key, address, before=cookie_in(request.scope))
    except KeyRefused as error:
        return _refused(request, shell, error, leads_to)
    response = RedirectResponse(_own(leads_to), status_code=303)
    parts.logins.give(response, logged_in, encrypted=request.url.scheme == "https")
    return response


@router.post("/logout")
def post_logout(request: Request, parts: PartsOf, _: Reader, by: By) -> Response:
    """Let a browser out."""
    if request.state.logged_in is not None:
        parts.logins.end(request.state.logged_in, by=by)
    response = Response(status_code=204, headers={"HX-Redirect": "/login"})
    parts.logins.take_back(response, encrypted=request.url.scheme == "https")
    return response


def _refused(request: Request, shell: Shell, error: KeyRefused, leads_to: str) -> Response:
    page = shell.page(
        request,
        "shell/login.html",
        status=status_of(error),
        leads_to=leads_to,
        refused=str(error),
        active=None,
    )
    if isinstance(error, TooManyBadKeys):
        page.headers["Retry-After"] = str(error.retry_after_s)
    return page


def _from_elsewhere(request: Request) -> bool:
    """Tell whether a browser says that a page of another host made the call.

    It says where a call comes from to hosts it reaches encrypted; else it names the page's host,
    which a proxy in between may know by another name.
    """
    site = request.headers.get("sec-fetch-site")
    if site is not None:
        return site not in {"same-origin", "none"}
    origin = request.headers.get("origin")
    return origin is not None and urlsplit(origin).netloc != request.headers.get("host")


def _own(address: str) -> str:
    r"""Return the address where it is one of the station; the first page for any other.

    >>> _own("/passes?train=7"), _own("//elsewhere.example/"), _own("/\\elsewhere.example")
    ('/passes?train=7', '/now', '/now')
    """
    ours = address.startswith("/") and address[1:2] not in {"/", "\\"} and address.isprintable()
    return address if ours else _FIRST
