"""Lists in pages: the one idea of where a page ends and the next begins.

A page is found by the key of the last row before it, never by a count: rows that come meanwhile
shift nothing, and the thousandth page costs what the first does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Generic

from sqlalchemy import Select, tuple_
from sqlalchemy.orm import InstrumentedAttribute, Session

from station.store.tables.base import Row

Cursor = tuple[datetime, str]
"""Where a row stands in a list by time: its moment, and its id among those of the same moment."""


@dataclass(frozen=True, slots=True)
class Page(Generic[Row]):
    """Some rows of a list, and whether more follow."""

    rows: Sequence[Row]
    more: bool


@dataclass(frozen=True, slots=True)
class Span:
    """From one moment on, to before another; either may be open."""

    since: datetime | None = None
    until: datetime | None = None


ALWAYS = Span()


def page_of(session: Session, query: Select[Row], limit: int) -> Page[Row]:
    """Return the first rows of a query, and whether more follow."""
    rows = session.scalars(query.limit(limit + 1)).all()
    return Page(rows[:limit], more=len(rows) > limit)


def newest_page(
    session: Session,
    query: Select[Row],
    moment: InstrumentedAttribute[datetime],
    row_id: InstrumentedAttribute[str],
    *,
    limit: int,
    before: Cursor | None,
    span: Span = ALWAYS,
) -> Page[Row]:
    """Return rows of a query, the newest first, from those older than the key `before`."""
    if before is not None:
        query = query.where(tuple_(moment, row_id) < before)
    if span.since is not None:
        query = query.where(moment >= span.since)
    if span.until is not None:
        query = query.where(moment < span.until)
    return page_of(session, query.order_by(moment.desc(), row_id.desc()), limit)
