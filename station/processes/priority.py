"""Which process goes first where there are fewer cores than work."""

import gc
import os
import sys

_STEP = 5
_SWITCH_S = 0.0005


def yields() -> bool:
    """Tell whether this process goes behind others."""
    return os.getpriority(os.PRIO_PROCESS, 0) > 0


def yield_to_others() -> None:
    """Let this process, and those it starts, go behind the others where cores are few.

    A train that is measured keeps every core busy; cameras, disk and callers do not wait for it.
    The worker gives way to them by one step, and the processes it has calculate by one more: a
    wheel that passes now goes before those of a train that has gone.
    """
    os.nice(_STEP)


def answer_promptly() -> None:
    """Have the threads of this process take turns quickly; to be called when it is set up.

    A thread that puts a long answer together gives way only after the interpreter's interval, by
    default 5 ms, each time the thread that serves all connections wants to go on.  Beside two
    threads that calculate for 5 ms at a time, a third needed 8.5 ms for six system calls, at the
    99th percentile; with this 2 ms.
    """
    sys.setswitchinterval(_SWITCH_S)
    # What was imported stays. Each time the collector looks through its 200 000 objects, nobody
    # is answered for 0.1 s.
    gc.collect()
    gc.freeze()
