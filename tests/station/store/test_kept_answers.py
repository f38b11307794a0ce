"""Shows what the store keeps of calls that may come again, on each kind of database."""

from datetime import UTC, datetime, timedelta

from station.store.callers import Call, Standing, begin_call, forget_call, keep_answer

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
CALL = Call("controller", "k1", "f1")


def begin(store, call=CALL, at=NOON):
    with store.change() as session:
        standing, kept = begin_call(session, call, at=at)
        return standing, kept.body


def keep(store, call=CALL):
    with store.change() as session:
        keep_answer(session, call, status=202, headers={"location": "/v1/jobs/1"}, body=b"\x00{}")


def test_a_call_is_new_then_unanswered_then_answered(store):
    assert begin(store) == (Standing.NEW, None)
    assert begin(store) == (Standing.UNANSWERED, None)
    keep(store)
    assert begin(store) == (Standing.ANSWERED, b"\x00{}")
    assert begin(store, Call("controller", "k1", "f2"))[0] is Standing.OF_ANOTHER_CALL
    assert begin(store, Call("planner", "k1", "f2"))[0] is Standing.NEW


def test_what_is_forgotten_may_be_called_again(store):
    begin(store)
    with store.change() as session:
        forget_call(session, CALL)
    assert begin(store)[0] is Standing.NEW


def test_what_was_not_answered_stays_what_it_was_asked_as(store):
    begin(store)
    begin(store, at=NOON + timedelta(hours=1))
    with store.change() as session:
        standing, kept = begin_call(session, CALL, at=NOON + timedelta(hours=2))
        assert (standing, kept.asked_at) == (Standing.UNANSWERED, NOON)


def test_an_answer_is_kept_for_a_day(store):
    begin(store)
    keep(store)
    assert begin(store, at=NOON + timedelta(hours=24))[0] is Standing.ANSWERED
    assert begin(store, at=NOON + timedelta(hours=24, seconds=1))[0] is Standing.NEW
