"""A port for a server that is started later, and perhaps again and again."""

import secrets
import socket
from pathlib import Path

_GIVEN_OUT = Path("/proc/sys/net/ipv4/ip_local_port_range")
_LOWEST, _USUALLY_GIVEN_OUT = 10_000, 32_768
_TRIES = 100


def port_for_later() -> int:
    """Return a port of 127.0.0.1 that is free, and that the kernel gives to nobody of itself.

    One that was got by binding to port 0 may go to any connection that anybody opens until the
    server listens there, and once more while a server that was killed is started again.

    Raises
    ------
    OSError
        If everything that was tried is in use.
    """
    bound = _first_given_out()
    for _ in range(_TRIES):
        port = _LOWEST + secrets.randbelow(bound - _LOWEST)
        with socket.socket() as probe:
            # As servers bind: connections that have just ended do not keep a port.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"{_TRIES} ports of 127.0.0.1 from {_LOWEST} to {bound - 1} are in use")


def _first_given_out() -> int:
    try:
        first = int(_GIVEN_OUT.read_text(encoding="ascii").split()[0])
    except (OSError, ValueError, IndexError):
        return _USUALLY_GIVEN_OUT
    # A host that gives out nearly all of them leaves no others: then these are as good.
    return first if first > 2 * _LOWEST else _USUALLY_GIVEN_OUT
