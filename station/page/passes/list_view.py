"""The list of passes: what each came to, and what it raised."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

from sqlalchemy.orm import Session

from station.api import cursor_in, next_of
from station.page.passes.search import Search
from station.store import Pass, PassState, Recording
from station.store.lists import passes_page, recordings_by_pass
from station.trains import AlarmTally, alarm_tallies

_ROWS = 50
STATE_KIND: Mapping[PassState, str] = {
    PassState.ARMED: "busy",
    PassState.RECORDING: "busy",
    PassState.RECORDED: "warn",
    PassState.MEASURING: "busy",
    PassState.DONE: "good",
    PassState.FAILED: "bad",
    PassState.RECOVERED: "good",
}
"""How the badge of a state looks."""


@dataclass(frozen=True, slots=True)
class PassRow:
    """One pass of the list."""

    id: str
    train: str | None
    opened_at: datetime
    state: PassState
    kind: str
    """Of the state's badge."""
    axles: int | None
    lost: int
    """Frames that triggers were counted for, and that are not there."""
    tally: AlarmTally | None
    """None until its axles are known."""
    reason: str | None


@dataclass(frozen=True, slots=True)
class PassList:
    """A page of the list."""

    rows: tuple[PassRow, ...]
    older: str | None
    """Address of the next page; None on the last."""


def pass_list(session: Session, search: Search, zone: ZoneInfo | None) -> PassList:
    """Return the passes that are looked for, the newest first.

    Raises
    ------
    InputUnusable
        If the span of days is none, or `before` is not from the address of a page.
    """
    page = passes_page(
        session,
        limit=_ROWS,
        before=cursor_in(search.before or None),
        span=search.span(zone),
        state=search.state or None,
        wheelset=search.wheelset.strip() or None,
        id_holds=search.name.strip() or None,
        train_holds=search.train.strip() or None,
    )
    recordings = recordings_by_pass(session, page.rows)
    tallies = alarm_tallies(session, [row.id for row in page.rows])
    rows = tuple(_row(row, recordings.get(row.id, ()), tallies.get(row.id)) for row in page.rows)
    cursor = next_of(page.rows, lambda row: (row.opened_at, row.id), more=page.more)
    return PassList(rows, None if cursor is None else search.older(cursor))


def _row(row: Pass, recordings: Sequence[Recording], tally: AlarmTally | None) -> PassRow:
    return PassRow(
        id=row.id,
        train=row.train,
        opened_at=row.opened_at,
        state=row.state,
        kind=STATE_KIND[row.state],
        axles=row.axles if tally is None else tally.wheels // 2,
        lost=sum(recording.lost or 0 for recording in recordings),
        tally=tally,
        reason="; ".join(why for why in (row.ended_why, row.reason) if why) or None,
    )
