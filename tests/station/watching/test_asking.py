"""Shows that whoever never answers is waited for once, and holds one thread."""

import threading
import time

import pytest

from station.watching import Asker, answers_of

LONG_S = 60.0


@pytest.fixture
def gate():
    gate = threading.Event()
    yield gate
    gate.set()


def test_answers_and_errors_come_back_by_name():
    def refuse():
        raise OSError("gone")

    found = answers_of({"a": Asker("a", lambda: 1), "b": Asker("b", refuse)}, LONG_S)
    assert found["a"] == 1
    assert str(found["b"]) == "gone"


def test_one_that_hangs_is_waited_for_once_and_never_asked_twice_at_a_time(gate):
    asked = []

    def hang():
        asked.append(1)
        gate.wait(LONG_S)
        return "late"

    askers = {"hangs": Asker("hangs", hang), "well": Asker("well", lambda: "well")}
    assert answers_of({"hangs": askers["hangs"]}, 0.01) == {"hangs": None}
    began_s = time.monotonic()
    assert answers_of(askers, LONG_S) == {"hangs": None, "well": "well"}
    assert time.monotonic() - began_s < LONG_S / 2.0
    assert len(asked) == 1
    gate.set()
    assert askers["hangs"].wait(LONG_S) == "late"
    assert answers_of(askers, LONG_S) == {"hangs": "late", "well": "well"}
    assert len(asked) == 2
