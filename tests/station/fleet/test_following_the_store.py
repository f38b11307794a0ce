"""Shows that every table that is followed has its triggers, and what a change counts for."""

from datetime import UTC, datetime

import pytest
from newest_schema import make_store
from sqlalchemy import delete, text

from station.store import (
    EMPTY,
    AxleWheel,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    Store,
    migrate,
)
from station.store.changes import (
    ChangeKind,
    begin_epoch,
    changes_after,
    changes_left,
    knows_push,
    note_push,
    store_epoch,
)
from station.store.connecting import open_engine

AT = datetime(2026, 7, 1, tzinfo=UTC)
FOLLOWED = {
    "passes",
    "measurements",
    "axle_wheels",
    "activations",
    "rig_activations",
    "recalibrations",
}


@pytest.fixture
def store(any_url):
    make_store(any_url)
    store = Store.open(any_url)
    yield store
    store.close()


def noted(store, after=0):
    with store.look() as session:
        return [(row.kind, row.key) for row in changes_after(session, after, limit=100)]


def add_pass(store, name="p"):
    with store.change() as session:
        session.add(Pass(id=name, state=PassState.DONE, opened_at=AT))


def test_every_followed_table_has_its_triggers_at_the_newest_revision(any_url):
    migrate(any_url)
    engine = open_engine(any_url)
    on_sqlite = engine.dialect.name == "sqlite"
    query = (
        "SELECT DISTINCT tbl_name FROM sqlite_master WHERE type = 'trigger'"
        if on_sqlite
        else "SELECT DISTINCT event_object_table FROM information_schema.triggers"
    )
    with engine.connect() as connection:
        found = set(connection.scalars(text(query)))
    engine.dispose()
    assert found >= FOLLOWED


def test_what_was_there_before_the_first_change_was_noted_is_sent_too(any_url):
    migrate(any_url)
    migrate(any_url, "0015")
    engine = open_engine(any_url)
    with engine.begin() as connection:
        for name, day in (("late", 2), ("early", 1)):
            connection.execute(
                text(
                    "INSERT INTO passes (id, state, opened_at) VALUES"
                    f" ('{name}', 'done', '2026-07-0{day} 12:00:00')"
                )
            )
    engine.dispose()
    migrate(any_url)
    store = Store.open(any_url)
    assert noted(store) == [("pass", "early"), ("pass", "late")]
    add_pass(store)
    assert noted(store)[-1] == ("pass", "p")
    store.close()
    migrate(any_url, EMPTY)
    migrate(any_url)


def test_what_is_written_again_moves_to_the_end(store):
    add_pass(store, "p")
    add_pass(store, "q")
    with store.look() as session:
        before = changes_after(session, 0, limit=100)[-1].number
    with store.change() as session:
        session.get(Pass, "p").train = "T"
    assert noted(store, before) == [("pass", "p")]
    assert noted(store) == [("pass", "q"), ("pass", "p")]
    with store.look() as session:
        assert changes_left(session, before).count == 1
        assert changes_left(session, before + 1).since is None


def test_axles_taken_away_are_a_change_of_their_pass(store):
    add_pass(store)
    with store.change() as session:
        session.add(
            AxleWheel(
                pass_id="p",
                place=1,
                side="left",
                placing="certain",
                others={"measurements": []},
                jumps={},
            )
        )
    number = last(store)
    with store.change() as session:
        session.execute(delete(AxleWheel))
    assert last(store) > number
    assert noted(store) == [("pass", "p")]


def last(store):
    with store.look() as session:
        return changes_after(session, 0, limit=100)[-1].number


def test_a_change_that_is_taken_back_is_none(store):
    with pytest.raises(RuntimeError):
        _add_pass_and_fail(store)
    assert noted(store) == []


def _add_pass_and_fail(store):
    with store.change() as session:
        session.add(Pass(id="p", state=PassState.DONE, opened_at=AT))
        session.flush()
        raise RuntimeError


def test_a_night_is_followed_from_its_order_to_its_answer(store):
    with store.change() as session:
        session.add(
            Recalibration(
                id="n",
                state=RecalibrationState.WAITING,
                sensor="left",
                ordered_at=AT,
                ordered_by="somebody",
                job_id="j",
                findings={},
                version=1,
            )
        )
    number = last(store)
    with store.change() as session:
        session.get(Recalibration, "n").outcome = "consistent"
    assert noted(store, number) == [(ChangeKind.RECALIBRATION, "n")]


def test_an_epoch_begun_by_two_at_a_time_is_one(store):
    with store.change() as session:
        assert store_epoch(session) is None
        first = begin_epoch(session, after=None, at=AT)
        assert begin_epoch(session, after=None, at=AT) == first
        second = begin_epoch(session, after=first, at=AT)
        assert second != first
        assert store_epoch(session) == second


def test_a_push_is_known_until_ten_thousand_later(store, monkeypatch):
    monkeypatch.setattr("station.store.changes._PUSHES_KEPT", 3)
    with store.change() as session:
        tokens = [note_push(session, number, at=AT) for number in range(5)]
        assert [knows_push(session, token) for token in tokens] == [False, False, True, True, True]
