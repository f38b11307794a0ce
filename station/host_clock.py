"""The clock of this host as the kernel keeps it: whether somebody keeps it right."""

import ctypes
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

_UNSYNCHRONISED = 0x0040  # STA_UNSYNC of <sys/timex.h>
_LARGEST_ERROR_S = 1.1
"""The kernel lets its bound grow by half a millisecond a second, and systemd-timesyncd asks every
34 minutes.  Beyond it, whoever kept the clock has stopped."""


class _Timex(ctypes.Structure):
    """``struct timex`` as adjtimex(2) has it."""

    _fields_ = (
        ("modes", ctypes.c_uint),
        ("offset", ctypes.c_long),
        ("freq", ctypes.c_long),
        ("maxerror", ctypes.c_long),
        ("esterror", ctypes.c_long),
        ("status", ctypes.c_int),
        ("rest", ctypes.c_long * 40),  # more than any version has; the kernel writes it
    )


@dataclass(frozen=True, slots=True)
class ClockState:
    """What the kernel says of its clock."""

    synchronised: bool
    largest_error_s: float
    """The bound that whoever keeps it gives; it grows while nobody does."""

    @property
    def kept(self) -> bool:
        """Whether somebody keeps the clock right."""
        return self.synchronised and self.largest_error_s <= _LARGEST_ERROR_S


def clock_state(adjtimex: Callable[[Any], int] | None = None) -> ClockState:
    """Ask the kernel, changing nothing; OSError where it does not answer."""
    state = _Timex()  # modes 0: read only
    ask = adjtimex or ctypes.CDLL(None, use_errno=True).adjtimex
    if ask(ctypes.byref(state)) < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return ClockState(not state.status & _UNSYNCHRONISED, state.maxerror * 1e-6)
