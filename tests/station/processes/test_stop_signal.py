"""A signal to stop is heard at any moment, also while it is being heard."""

import os
import signal
import subprocess
import sys
import time

import pytest

from station.processes.stop_signal import StopSignal

PATIENCE_S = 20.0
HEARS_IT_AT_EVERY_CALL = """
import signal, sys
from station.processes.stop_signal import StopSignal
stop = StopSignal()
sys.setprofile(lambda *_: signal.raise_signal(signal.SIGTERM))
signal.raise_signal(signal.SIGTERM)
sys.setprofile(None)
print(stop.wait(0.0))
"""


def test_signal_ends_a_wait_and_stays_set():
    with StopSignal() as stop:
        assert not stop.is_set()
        assert not stop.wait(0.0)
        os.kill(os.getpid(), signal.SIGTERM)
        began = time.monotonic()
        assert stop.wait(PATIENCE_S)
        assert stop.wait()
        assert stop.is_set()
        assert time.monotonic() - began < PATIENCE_S


def test_handlers_are_as_before_afterwards():
    before = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)]
    with pytest.raises(KeyError), StopSignal():
        raise KeyError
    assert [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)] == before


def test_signals_one_on_top_of_another_are_one():
    """A killed supervisor's threads die one by one, and each death is told to its children."""
    reply = subprocess.run(
        [sys.executable, "-c", HEARS_IT_AT_EVERY_CALL],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert (reply.stdout, reply.stderr, reply.returncode) == ("True\n", "", 0)
