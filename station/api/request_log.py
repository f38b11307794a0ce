"""The line of the log for an answered call, and the names by which its other lines are found."""

import re
from contextlib import AbstractContextManager
from typing import Final
from uuid import uuid4

import structlog
from starlette.datastructures import Headers
from starlette.types import Scope

from station.api.guard import OPEN
from station.log_ids import about

REQUEST_ID: Final = "X-Request-Id"
_GIVEN = re.compile(r"[A-Za-z0-9._-]{1,64}")
_ID = r"[A-Za-z0-9][A-Za-z0-9._-]{0,127}"
_NAMED = re.compile(
    rf"/v1/(?:passes/(?P<pass_id>{_ID})|calibration-sessions/(?P<session>{_ID})"
    rf"|recordings/(?P<recording>{_ID})|jobs/(?P<job>{_ID})|sensors/(?P<sensor>{_ID}))(?:/|$)"
)
_READS: Final = frozenset({"GET", "HEAD"})
_SLOW_S: Final = 1.0
_LONGEST_PATH: Final = 200
_log = structlog.get_logger()


def request_id_of(scope: Scope) -> str:
    """Return the caller's own id of a call where it gives one that can be logged, or a new one."""
    given = Headers(scope=scope).get(REQUEST_ID, "")
    return given if _GIVEN.fullmatch(given) else uuid4().hex[:12]


def about_call(scope: Scope, request_id: str) -> AbstractContextManager[None]:
    """Have what is logged in the block name the call, and what its address is about."""
    found = _NAMED.match(scope["path"])
    return about(request=request_id, **({} if found is None else found.groupdict()))


def note_answer(scope: Scope, status: int, seconds: float) -> None:
    """Log an answered call.

    At 200 calls a second a line for each would be 4 GB a day, and hide what matters: a read that
    succeeds in its time is told at `debug` alone; the metrics count it.  Probes are not told at
    all.
    """
    if scope["path"] in OPEN:
        return
    usual = scope["method"] in _READS and status < 400 and seconds <= _SLOW_S
    say = _log.debug if usual else _log.warning if status >= 500 else _log.info
    caller = scope.get("state", {}).get("caller")
    say(
        "answered",
        method=scope["method"],
        route=getattr(scope.get("route"), "path", None),
        path=scope["path"][:_LONGEST_PATH],
        status=status,
        ms=round(1000.0 * seconds, 1),
        who=None if caller is None else caller.name,
        address=(scope.get("client") or (None,))[0],
    )
