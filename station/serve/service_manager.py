"""Telling systemd how the service does: ready, alive, ending.

As of sd_notify(3) and sd_watchdog_enabled(3).  Without systemd nothing is told, and nothing else is
different.
"""

import os
import socket
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, Self

_NOTIFY_SOCKET: Final = "NOTIFY_SOCKET"
_WATCHDOG_US: Final = "WATCHDOG_USEC"
_WATCHDOG_PID: Final = "WATCHDOG_PID"
_SIGNS_A_PERIOD: Final = 3
"""A sign of life that comes a little late is not the end."""


@dataclass(frozen=True, slots=True)
class ServiceManager:
    """Whoever started the station as a service, if anybody did."""

    address: str | None = None
    sign_every_s: float | None = None
    """How often it wants a sign of life; None where it does not."""

    @classmethod
    def of(cls, environment: Mapping[str, str]) -> Self:
        """Find it by what it puts into the environment of a service."""
        path = environment.get(_NOTIFY_SOCKET)
        if not path:
            return cls()
        meant = environment.get(_WATCHDOG_PID, str(os.getpid())) == str(os.getpid())
        period = environment.get(_WATCHDOG_US, "")
        every_s = int(period) / 1e6 / _SIGNS_A_PERIOD if meant and period.isdigit() else None
        # The kernel's abstract names begin with a zero byte, written as @.
        return cls("\0" + path[1:] if path.startswith("@") else path, every_s)

    def tell_ready(self) -> None:
        """Tell that the station serves; what waits for it may start."""
        self._tell("READY=1")

    def tell_alive(self) -> None:
        """Give a sign of life."""
        if self.sign_every_s is not None:
            self._tell("WATCHDOG=1")

    def tell_ending(self) -> None:
        """Tell that the station is being stopped."""
        self._tell("STOPPING=1", "STATUS=stopping: recordings are being closed")

    def tell_status(self, line: str) -> None:
        """Tell people in one line how the station does; `systemctl status` shows it."""
        self._tell("STATUS=" + " ".join(line.split()))

    def _tell(self, *fields: str) -> None:
        if self.address is None:
            return
        # Nobody who listens is no reason for a station to end.
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sending:
            sending.sendto("\n".join(fields).encode(), self.address)
