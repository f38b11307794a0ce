"""The addresses of the page."""

from fastapi import APIRouter, Request, Response

from station.api import Reader
from station.page.shell import ShellOf

router = APIRouter()


@router.get("/set-up")
def get_page(request: Request, shell: ShellOf, _: Reader) -> Response:
    """Return the page."""
    return shell.page(request, "set_up/index.html", active="set_up")
