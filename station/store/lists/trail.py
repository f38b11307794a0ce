"""The audit trail, the newest first."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.store.lists.paging import Page, page_of
from station.store.tables import AuditEntry


def audit_page(
    session: Session,
    *,
    limit: int,
    before: int | None = None,
    subject: str | None = None,
    who: str | None = None,
) -> Page[AuditEntry]:
    """Return entries of the trail, the newest first, from those older than the key `before`."""
    query = select(AuditEntry).order_by(AuditEntry.id.desc())
    if before is not None:
        query = query.where(AuditEntry.id < before)
    if subject is not None:
        query = query.where(AuditEntry.subject == subject)
    if who is not None:
        query = query.where(AuditEntry.who == who)
    return page_of(session, query, limit)
