"""Asking an address whether a GigE Vision camera is there, simulated or real."""

import contextlib
import socket
import time
from ipaddress import IPv4Address

from station.simulated import gvcp
from station.simulated.gvcp import Acknowledge, Command, MalformedPacket, Request, Status
from station.simulated.identity import Identity

_ASK_AGAIN_S = 0.2
_REQUEST_ID = 1


def probe_camera(address: IPv4Address, timeout_s: float = 1.0) -> Identity | None:
    """Return who answers at an address, or None where nobody does in time."""
    question = Request(Command.DISCOVERY, _REQUEST_ID).encode()
    until_s = time.monotonic() + timeout_s
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asker:
        asker.settimeout(min(_ASK_AGAIN_S, timeout_s))
        while time.monotonic() < until_s:
            # A closed port answers with ICMP, seen here as an error: as good as silence.
            with contextlib.suppress(TimeoutError, OSError, MalformedPacket):
                asker.sendto(question, (str(address), gvcp.PORT))
                answer = Acknowledge.decode(asker.recv(2048))
                if answer.status == Status.SUCCESS and answer.command == Command.DISCOVERY:
                    return Identity.from_discovery(answer.payload)
    return None
