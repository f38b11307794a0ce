"""Shows that several processes can write to the store, and that what was committed stays."""

import threading
from datetime import UTC, datetime, timedelta, timezone

import pytest
from sqlalchemy import text

from station.errors import NotFound
from station.store import JobKind, Pass, PassState, Store, add_job, the, unfinished_jobs

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def a_pass(pass_id, at=NOON):
    return Pass(id=pass_id, state=PassState.ARMED, opened_at=at)


def test_the_database_waits_for_writers_and_survives_a_power_cut(sqlite_store):
    with sqlite_store.look() as session:
        pragma = lambda name: session.execute(text(f"PRAGMA {name}")).scalar()  # noqa: E731
        assert pragma("journal_mode") == "wal"
        assert pragma("synchronous") == 2  # FULL
        assert pragma("foreign_keys") == 1
        assert pragma("busy_timeout") >= 5_000


def test_two_stores_that_read_and_then_write_never_meet_a_locked_database(any_url, store):
    """With a deferred BEGIN nearly each of these transactions fails."""
    rounds, failures = 60, []

    def write(name):
        own = Store.open(any_url)
        for n in range(rounds):
            try:
                with own.change() as session:
                    count = len(unfinished_jobs(session))
                    add_job(session, f"{name}-{n}", JobKind.MEASURE, str(count), at=NOON)
            except Exception as error:  # noqa: BLE001  any is a failure of the test
                failures.append(error)
        own.close()

    writers = [threading.Thread(target=write, args=(name,)) for name in "abc"]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    assert failures == []
    with store.look() as session:
        jobs = unfinished_jobs(session)
    assert len(jobs) == 3 * rounds
    # No lost update: each transaction saw all that were committed before it.
    assert sorted(int(job.subject) for job in jobs) == list(range(3 * rounds))


def test_a_block_that_fails_leaves_nothing(store):
    def fail_in_the_middle():
        with store.change() as session:
            session.add(a_pass("p1"))
            session.flush()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_in_the_middle()
    with store.look() as session, pytest.raises(NotFound, match="pass 'p1'"):
        the(session, Pass, "p1")


def test_moments_come_back_in_utc_whatever_zone_they_went_in(store):
    east = NOON.astimezone(timezone(timedelta(hours=9)))
    with store.change() as session:
        session.add(a_pass("p1", at=east))
    with store.look() as session:
        found = the(session, Pass, "p1").opened_at
    assert found == NOON
    assert found.tzinfo is UTC
