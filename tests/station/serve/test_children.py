"""Shows when the supervisor starts a process again and how it ends one.  Clock and processes are
doubles; real ones die in the test of the whole service."""

from dataclasses import dataclass

import pytest

from station.serve.children import Child


class Clock:
    now_s = 100.0

    def __call__(self):
        return self.now_s


@dataclass
class FakeHandle:
    pid: int | None = None
    exitcode: int | None = None
    obeys: bool = True
    killed: bool = False

    def terminate(self):
        if self.obeys:
            self.exitcode = 0

    def kill(self):
        self.killed, self.exitcode = True, -9

    def join(self, timeout=None): ...


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def child(clock):
    child = Child("worker", FakeHandle, patience_s=1.0, clock=clock)
    child.start()
    return child


def die(child, clock, after_s):
    clock.now_s += after_s
    child.handle.exitcode = -9
    child.mend()
    return child.due_s()


def start_again(child, clock):
    clock.now_s += child.due_s()
    child.mend()


def test_a_process_that_runs_is_left_alone(child, clock):
    handle = child.handle
    clock.now_s += 1000.0
    child.mend()
    assert child.handle is handle
    assert child.due_s() is None


def test_a_process_that_ended_is_started_again_after_its_pause_and_not_before(child, clock):
    pause_s = die(child, clock, after_s=60.0)
    assert 0.0 < pause_s < 1.0
    clock.now_s += 0.9 * pause_s
    child.mend()
    assert (child.handle, child.restarts) == (None, 0)
    clock.now_s += 0.2 * pause_s
    child.mend()
    assert (child.handle.exitcode, child.restarts) == (None, 1)


def test_a_process_that_keeps_on_ending_is_started_ever_more_slowly(child, clock):
    pauses = []
    for _ in range(12):
        pauses.append(die(child, clock, after_s=0.1))
        start_again(child, clock)
    assert pauses == sorted(pauses)
    assert pauses[-1] == 10.0
    assert die(child, clock, after_s=31.0) < 1.0


def test_a_process_ends_when_asked_and_by_force_when_it_does_not(child, clock):
    obedient = child.handle
    child.ask_to_end()
    child.ensure_ended()
    assert (obedient.exitcode, obedient.killed) == (0, False)
    child.start()
    stubborn = child.handle
    stubborn.obeys = False
    child.ask_to_end()
    child.ensure_ended()
    assert stubborn.killed
    child.ask_to_end()
    child.ensure_ended()
