"""Shows that pages are found by their key on either database, rows of one moment among them."""

from datetime import UTC, datetime, timedelta, timezone

from station.store import AxleWheel, Pass, PassState, Recording
from station.store.lists import Span, passes_page, recordings_by_pass, recordings_page

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def fill(store):
    with store.change() as session:
        for number in range(6):
            at = NOON + timedelta(microseconds=number // 2)
            session.add(Pass(id=f"p{number}", state=PassState.DONE, opened_at=at))
        session.flush()
        for number in range(6):
            session.add(
                Recording(
                    id=f"r{number}",
                    sensor="left",
                    pass_id=f"p{number}",
                    path="x",
                    opened_at=NOON,
                    recovered=False,
                )
            )
        for place in (1, 2):
            session.add(
                AxleWheel(
                    pass_id="p2",
                    place=place,
                    side="left",
                    placing="certain",
                    others={"measurements": []},
                    wheelset="ws",
                    jumps={},
                )
            )


def test_pages_of_two_hold_every_row_once_though_moments_are_shared(store):
    fill(store)
    found, before = [], None
    with store.look() as session:
        while True:
            page = passes_page(session, limit=2, before=before)
            found += [row.id for row in page.rows]
            if not page.more:
                break
            before = page.rows[-1].opened_at, page.rows[-1].id
        assert found == ["p5", "p4", "p3", "p2", "p1", "p0"]
        by_pass = recordings_by_pass(session, page.rows)
        assert {name: [row.id for row in rows] for name, rows in by_pass.items()} == {
            "p0": ["r0"],
            "p1": ["r1"],
        }
        rest = recordings_page(session, limit=9, before=(NOON, "r2"))
        assert [row.id for row in rest.rows] == ["r1", "r0"]


def test_a_moment_of_another_zone_is_the_same_moment(store):
    fill(store)
    east = timezone(timedelta(hours=9))
    second = (NOON + timedelta(microseconds=1)).astimezone(east)
    with store.look() as session:
        page = passes_page(session, limit=9, span=Span(since=second, until=None))
        assert [row.id for row in page.rows] == ["p5", "p4", "p3", "p2"]
        page = passes_page(session, limit=9, span=Span(since=None, until=second))
        assert [row.id for row in page.rows] == ["p1", "p0"]


def test_a_wheelset_that_is_twice_in_a_pass_gives_the_pass_once(store):
    fill(store)
    with store.look() as session:
        page = passes_page(session, limit=9, wheelset="ws")
        assert [row.id for row in page.rows] == ["p2"]
