"""Shows that passes are looked after again and again, whatever one look runs into."""

import json
import threading

from station.errors import StoreUnusable
from station.serve import log_as
from station.serve.looking import begin_looking

PATIENCE_S = 30.0


def test_a_look_that_fails_is_logged_once_and_the_next_ones_come(capsys):
    log_as("test")
    stop, looked = threading.Event(), []

    def look():
        looked.append(len(looked))
        if len(looked) in {1, 2}:
            raise StoreUnusable("the store cannot be used now")
        if len(looked) == 3:
            raise ZeroDivisionError
        stop.set()

    thread = begin_looking(look, stop, every_s=0.0)
    thread.join(PATIENCE_S)
    assert not thread.is_alive()
    assert looked == [0, 1, 2, 3]
    lines = [json.loads(line) for line in capsys.readouterr().err.splitlines()]
    assert [line["why"] for line in lines] == [
        "StoreUnusable('the store cannot be used now')",
        "ZeroDivisionError()",
    ]


def test_nothing_is_looked_at_once_it_is_told_to_stop():
    stop = threading.Event()
    stop.set()
    looked = []
    begin_looking(lambda: looked.append(1), stop).join(PATIENCE_S)
    assert looked == []
