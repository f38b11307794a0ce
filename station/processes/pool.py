"""Processes that calculate for this one, one core each."""

import os
import signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from station.processes.lifeline import end_with_parent
from station.processes.one_core import use_one_core
from station.processes.priority import yield_to_others, yields
from station.processes.stop_signal import STOP_SIGNALS


def pool_of_processes(count: int) -> ProcessPoolExecutor:
    """Return a pool whose processes end with this one, and not before the thread that uses it.

    By themselves they would wait for work for ever after this one was killed.  They are spawned,
    never forked: the callers hold threads.
    """
    return ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=_begin, initargs=(os.getpid(),)
    )


def _begin(parent_pid: int) -> None:
    end_with_parent(parent_pid, signal.SIGKILL)
    # A service manager's TERM and a terminal's Ctrl-C reach every process; when the work is to be
    # left is for the one to say that wants its answers.
    for number in STOP_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    if yields():  # for a person who waits at a terminal it does not
        yield_to_others()
    use_one_core()
