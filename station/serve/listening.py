"""The socket of the page and API: opened by the supervisor, so that it outlives the API process."""

import errno
import os
import socket

from station.errors import InputUnusable
from station.settings import TlsSettings

_BACKLOG = 128


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 takes a free one.

    Calls that come while the API process is started again wait in its queue.

    Raises
    ------
    InputUnusable
        If the port is in use or not allowed, or the host has no such address.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
    except OSError as error:
        raise InputUnusable(
            f"host {host!r}: {error.strerror}; give an address of this host"
        ) from error
    listening = socket.socket(family, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host, port))
        listening.listen(_BACKLOG)
    except OSError as error:
        listening.close()
        raise InputUnusable(_refusal(host, port, error)) from error
    return listening


def _refusal(host: str, port: int, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"port {port} of {host} is in use; stop what listens there, or set another port"
    if error.errno == errno.EACCES:
        return f"port {port} of {host} is not allowed to this user; set one from 1024 on"
    return f"{host} port {port}: {os.strerror(error.errno or 0)}; give an address of this host"


def url_of(listening: socket.socket, tls: TlsSettings | None = None) -> str:
    """Return the URL under which the socket is reached."""
    host, port = listening.getsockname()[:2]
    scheme = "http" if tls is None else "https"
    return f"{scheme}://[{host}]:{port}" if ":" in host else f"{scheme}://{host}:{port}"
