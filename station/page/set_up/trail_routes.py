"""The address of the audit trail: for administrators alone."""

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from station.api import Administrator, PartsOf
from station.page.set_up.frame import parts_for
from station.page.shell import ShellOf
from station.store.lists import audit_page

router = APIRouter(prefix="/set-up")

_SHOWN = 50
_LARGEST_ID = 2**31 - 1  # what an integer column of PostgreSQL holds
_Wanted = Annotated[str, Query(max_length=256, pattern=r"^[^\x00]*$")]


@router.get("/audit")
def get_audit(
    request: Request,
    parts: PartsOf,
    shell: ShellOf,
    caller: Administrator,
    subject: _Wanted = "",
    who: _Wanted = "",
    before: Annotated[int | None, Query(ge=1, le=_LARGEST_ID)] = None,
) -> Response:
    """Return entries of the audit trail, the newest first."""
    with parts.station.store.look() as session:
        page = audit_page(
            session,
            limit=_SHOWN,
            before=before,
            subject=subject.strip() or None,
            who=who.strip() or None,
        )
    return shell.page(
        request,
        "set_up/audit.html",
        active="set_up",
        parts_here=parts_for(caller),
        entries=page.rows,
        subject=subject,
        who=who,
        next=page.rows[-1].id if page.more else None,
        first=before is None,
    )
