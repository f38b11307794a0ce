"""Ending with the process that started this one, however it ends."""

import ctypes
import os
import signal

_PR_SET_PDEATHSIG = 1


def end_with_parent(parent_pid: int, by: signal.Signals = signal.SIGTERM) -> None:
    """Have the kernel send this process a signal when its parent dies, even by SIGKILL.

    Without it a killed parent would leave processes that hold port, cores and memory, and the next
    start would find them taken.  The signal comes when the *thread* that started this process
    ends, and once for every other thread that inherits it then.

    Parameters
    ----------
    parent_pid
        As the parent knows it; asked for here it would be another's, had the parent died already.
    by
        SIGKILL for one that has nothing to finish.
    """
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, by, 0, 0, 0)
    if os.getppid() != parent_pid:  # it died before the line above
        os.kill(os.getpid(), by)
