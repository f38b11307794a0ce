"""Shows that each change counts on the tables it wrote to and no other ones, on both databases, and
that SQLite tells of it."""

import sqlite3
from datetime import UTC, datetime

import pytest
from sqlalchemy import insert, select
from sqlalchemy.exc import IntegrityError

from station.store import (
    Job,
    JobKind,
    JobState,
    Store,
    add_job,
    end,
    migrate,
    sqlite_url,
    tables_read,
)
from station.store.touched import TableRevision

AT = datetime(2026, 7, 1, tzinfo=UTC)


@pytest.fixture
def store(any_url):
    migrate(any_url)
    store = Store.open(any_url)
    yield store
    store.close()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "station.sqlite"
    migrate(sqlite_url(path))
    return path


def counts(store):
    with store.look() as session:
        return {row.name: row.number for row in session.scalars(select(TableRevision))}


def order(store, name="j1"):
    with store.change() as session:
        add_job(session, name, JobKind.COMPACT, "all", at=AT)


def order_twice(store):
    with store.change() as session:
        add_job(session, "j1", JobKind.COMPACT, "all", at=AT)
        session.flush()
        session.execute(insert(Job).values(id="j1"))


def test_a_change_counts_on_what_it_wrote_to(store):
    order(store)
    assert counts(store) == {"jobs": 1}
    with store.change() as session:
        end(session.get(Job, "j1"), JobState.CANCELLED, at=AT)
    assert counts(store) == {"jobs": 2}


def test_reading_and_what_is_taken_back_count_nothing(store):
    with store.change() as session:
        session.scalars(select(Job)).all()
    with pytest.raises(IntegrityError):
        order_twice(store)
    with store.change() as session:
        session.scalars(select(Job)).all()
    assert counts(store) == {}


def test_the_tables_that_are_read_within_a_block_are_told(store):
    with tables_read() as tables, store.look() as session:
        session.scalars(select(Job)).all()
    assert tables == {"jobs"}
    with store.look() as session:
        session.scalars(select(TableRevision)).all()
    assert tables == {"jobs"}


def test_a_revision_tells_what_was_written_to_and_what_was_not(file):
    store = Store.open(sqlite_url(file))
    with store.revisions() as revisions:
        first = revisions.now()
        assert revisions.now() is first
        order(store)
        second = revisions.now()
        assert second.of(["jobs"]) != first.of(["jobs"])
        assert second.of(["passes"]) == first.of(["passes"])
    store.close()


def test_a_write_that_counts_nothing_on_makes_every_table_another(file):
    store = Store.open(sqlite_url(file))
    with store.revisions() as revisions:
        first = revisions.now()
        with sqlite3.connect(file) as somebody:
            somebody.execute("DELETE FROM jobs")
            somebody.execute("INSERT INTO table_revisions VALUES ('jobs', 0)")
            somebody.execute("DELETE FROM table_revisions")
        somebody.close()
        assert revisions.now().of(["passes"]) != first.of(["passes"])
    store.close()


def test_a_connection_opened_anew_believes_nothing_of_before(file):
    store = Store.open(sqlite_url(file))
    revisions = store.revisions()
    first = revisions.now()
    revisions.close()
    assert revisions.now().of(["jobs"]) != first.of(["jobs"])
    revisions.close()
    store.close()


def test_without_a_store_nothing_is_known(tmp_path):
    store = Store.open(sqlite_url(tmp_path / "none" / "station.sqlite"))
    with store.revisions() as revisions:
        assert revisions.now() is None
    store.close()
