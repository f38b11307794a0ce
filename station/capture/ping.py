"""Whether a camera is there, asked in a fraction of the time the driver takes to give up.

Aravis asks five times and waits half a second for each answer; meanwhile the capture process would
be deaf.  A GigE Vision device answers discovery from anybody, whoever controls it.
"""

import socket

_PORT = 3956
_DISCOVERY = bytes.fromhex("42 01 0002 0000 0001")  # key, answer wanted, command, length, id
_DISCOVERY_ACK = bytes.fromhex("0003")
_TRIES = 3
_WAIT_S = 0.2


def answers_ping(address: str) -> bool:
    """Return whether a GigE Vision device answers at an IPv4 address, within 0.6 s."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.settimeout(_WAIT_S)
        for _ in range(_TRIES):
            try:
                asking.connect((address, _PORT))
                asking.send(_DISCOVERY)
                if asking.recv(1024)[2:4] == _DISCOVERY_ACK:
                    return True
            except OSError:  # silence, or nobody listens at the port
                continue
    return False
