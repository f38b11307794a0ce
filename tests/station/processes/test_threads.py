"""Shows several things done at a time, each thread knowing what its caller's lines are about."""

import threading

import pytest
from structlog.contextvars import get_contextvars

from station.log_ids import about
from station.processes.threads import at_a_time


def test_answers_come_in_order_though_all_are_done_at_a_time():
    together = threading.Barrier(3, timeout=30.0)

    def do(thing):
        together.wait()
        return thing * 2

    assert at_a_time(do, [1, 2, 3]) == [2, 4, 6]
    assert at_a_time(do, []) == []


def test_the_first_error_is_raised():
    def refuse(thing):
        raise ValueError(thing)

    with pytest.raises(ValueError, match="1"):
        at_a_time(refuse, [1, 2])


def test_a_thread_names_what_its_caller_names():
    with about(request="r1", pass_id="p1", sensor=None):
        names = at_a_time(lambda _: get_contextvars(), [1, 2])
    assert names == [{"request": "r1", "pass": "p1"}] * 2
    assert get_contextvars().get("request") is None
