"""Shows that the audit trail is written with the change and that nobody alters it afterwards, on
both databases.  Which operations write to it is shown with the API."""

from datetime import UTC, datetime, timedelta

import pytest
from sqlalchemy import text
from sqlalchemy.exc import DatabaseError

from station.store import Action, Actor, AuditEntry, audit
from station.store.lists import audit_page

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
PLC = Actor("plc", "10.0.0.7")


def note(session, subject, *, by=PLC, minutes=0):
    at = NOON + timedelta(minutes=minutes)
    audit(session, Action.CANCEL, "job", subject, by=by, at=at, before={"state": "running"})


def test_an_entry_says_who_did_what_to_what_when_and_from_where(store):
    with store.change() as session:
        note(session, "j1")
    with store.look() as session:
        (entry,) = audit_page(session, limit=9).rows
    assert (entry.who, entry.address, entry.action) == ("plc", "10.0.0.7", "cancel")
    assert (entry.kind, entry.subject, entry.at) == ("job", "j1", NOON)
    assert (entry.before, entry.after) == ({"state": "running"}, None)


def test_a_change_that_fails_leaves_no_entry(store):
    def change_and_fail():
        with store.change() as session:
            note(session, "j1")
            session.flush()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        change_and_fail()
    with store.look() as session:
        assert audit_page(session, limit=9).rows == []


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE audit_entries SET who = 'nobody'",
        "DELETE FROM audit_entries",
        "DELETE FROM audit_entries WHERE id = 1",
    ],
)
def test_the_database_itself_refuses_to_alter_or_delete_an_entry(store, statement):
    with store.change() as session:
        note(session, "j1")

    def alter():
        with store.change() as session:
            session.execute(text(statement))

    with pytest.raises(DatabaseError, match="only added to"):
        alter()
    with store.look() as session:
        assert [entry.who for entry in audit_page(session, limit=9).rows] == ["plc"]


def test_no_entry_is_replaced_on_sqlite_nor_the_trail_emptied_on_postgresql(store):
    with store.change() as session:
        note(session, "j1")

    def alter():
        with store.change() as session:
            if session.get_bind().dialect.name == "sqlite":
                columns = "id, at, who, action, kind, subject"
                values = "1, '2026-07-01', 'nobody', 'cancel', 'job', 'j1'"
                session.execute(
                    text(f"INSERT OR REPLACE INTO audit_entries ({columns}) VALUES ({values})")
                )
            else:
                session.execute(text("TRUNCATE audit_entries"))

    with pytest.raises(DatabaseError, match="only added to"):
        alter()


def test_an_entry_is_not_altered_through_its_row_either(store):
    with store.change() as session:
        note(session, "j1")

    def alter():
        with store.change() as session:
            session.get(AuditEntry, 1).who = "nobody"

    with pytest.raises(DatabaseError, match="only added to"):
        alter()


def test_pages_go_from_the_newest_to_the_oldest_without_gap(store):
    with store.change() as session:
        for n in range(5):
            note(session, f"j{n}", minutes=n)
            session.flush()
    with store.look() as session:
        first = audit_page(session, limit=2)
        second = audit_page(session, limit=9, before=first.rows[-1].id)
        one = audit_page(session, limit=9, subject="j3", who="plc")
    assert [entry.subject for entry in first.rows] == ["j4", "j3"]
    assert first.more
    assert [entry.subject for entry in second.rows] == ["j2", "j1", "j0"]
    assert [entry.subject for entry in one.rows] == ["j3"]
