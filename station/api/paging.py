"""The `next` of a page as text: where a list goes on, for whoever asks with it as `before`."""

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Annotated, TypeVar

from fastapi import Query
from pydantic import AfterValidator, AwareDatetime, BeforeValidator

from station.errors import InputUnusable
from station.store.lists import Cursor, Span

Row = TypeVar("Row")

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,127}")

_DATE = re.compile(r"\d{4}-\d\d-\d\d")

Before = Annotated[str | None, Query(max_length=256, description="`next` of a page.")]


def _in_utc(moment: datetime) -> datetime:
    try:
        return moment.astimezone(UTC)
    except OverflowError:
        raise ValueError("before the year 1 or after 9999; give a moment between") from None


def _written_out(text: object) -> object:
    # A bare number would be taken as seconds since 1970, which the contract does not say.
    if isinstance(text, str) and not _DATE.match(text):
        raise ValueError("no moment; give one as 2026-07-01T12:00:00Z")
    return text


Moment = Annotated[AwareDatetime, BeforeValidator(_written_out), AfterValidator(_in_utc)]
Since = Annotated[Moment | None, Query(alias="from", description="From this moment on.")]
Until = Annotated[Moment | None, Query(alias="to", description="Before this moment.")]


def span_of(since: datetime | None, until: datetime | None) -> Span:
    """Return the time between two moments of a call.

    Raises
    ------
    InputUnusable
        If the second is not behind the first.
    """
    if since is not None and until is not None and not since < until:
        raise InputUnusable(f"from {since.isoformat()} to {until.isoformat()}: `to` comes later")
    return Span(since, until)


def next_of(rows: Sequence[Row], place: Callable[[Row], Cursor], *, more: bool) -> str | None:
    """Return what stands for the last row of a page, by its place in the list; None on the last.

    >>> next_of(["p1"], lambda name: (datetime(2026, 7, 1, 12, tzinfo=UTC), name), more=True)
    '2026-07-01T12:00:00+00:00 p1'
    """
    if not more:
        return None
    moment, row_id = place(rows[-1])
    return f"{moment.isoformat()} {row_id}"


def cursor_in(text: str | None) -> Cursor | None:
    """Return the row that `before` names; None where there is none.

    Raises
    ------
    InputUnusable
        If it is not the `next` of a page.
    """
    if text is None:
        return None
    moment, _, row_id = text.partition(" ")
    try:
        at = datetime.fromisoformat(moment)
        # One without a zone is none of ours, and what it means would depend on the host's.
        known = at.tzinfo is not None and _NAME.fullmatch(row_id) is not None
        cursor = (at.astimezone(UTC), row_id) if known else None
    except (ValueError, OverflowError):
        cursor = None
    if cursor is None:
        raise InputUnusable(f"before {text!r}: send `next` of a page, as it came")
    return cursor
