"""Who changed what."""

from typing import Annotated

from fastapi import APIRouter, Query

from station.api.audit_answers import AuditEntryModel, AuditPage
from station.api.callers import Administrator
from station.api.parts import PartsOf
from station.api.requests import Limit
from station.store.lists import audit_page

router = APIRouter(prefix="/v1/audit", tags=["station"])

_LARGEST_ID = 2**31 - 1  # what an integer column of PostgreSQL holds


@router.get("")
def list_audit(
    parts: PartsOf,
    _: Administrator,
    limit: Limit = 100,
    before: Annotated[
        int | None, Query(ge=1, le=_LARGEST_ID, description="`next` of a page.")
    ] = None,
    subject: Annotated[str | None, Query(max_length=256, pattern=r"^[^\x00]*$")] = None,
    who: Annotated[str | None, Query(max_length=256, pattern=r"^[^\x00]*$")] = None,
) -> AuditPage:
    """Return the audit trail, the newest entries first."""
    with parts.station.store.look() as session:
        page = audit_page(session, limit=limit, before=before, subject=subject, who=who)
    return AuditPage(
        entries=[AuditEntryModel.of(row) for row in page.rows],
        next=page.rows[-1].id if page.more else None,
    )
