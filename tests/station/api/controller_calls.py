"""The ways in which a call of a controller reaches a station, or does not."""

import json
import socket
import threading
import time
from dataclasses import dataclass, field
from urllib.parse import urlsplit

import httpx
from served_station import ADMIN_KEY

PATIENCE_S = 30.0
_AS_JSON = {"Content-Type": "application/json"}
_PROBE = b"GET /healthz HTTP/1.1\r\nHost: station\r\nConnection: close\r\n\r\n"


@dataclass(frozen=True)
class Asked:
    """A call as a controller means it."""

    method: str
    path: str
    body: object = None
    headers: dict[str, str] = field(default_factory=dict)

    @property
    def content(self) -> bytes:
        return b"" if self.body is None else json.dumps(self.body).encode()

    @property
    def keyed(self) -> bool:
        return "Idempotency-Key" in self.headers


def send(client, asked):
    """Send a call and return its answer."""
    return client.request(
        asked.method, asked.path, content=asked.content, headers={**_AS_JSON, **asked.headers}
    )


def send_twice(served, asked):
    """Send a call twice at the same moment, over two connections; return both answers."""
    answers, together = [], threading.Barrier(2)

    def one():
        with served.client() as client:
            together.wait(PATIENCE_S)
            answers.append(send(client, asked))

    threads = [threading.Thread(target=one) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE_S)
    return answers


def send_half(served, asked):
    """Send the first half of a call and go away."""
    whole = _on_the_wire(asked)
    _send_bytes(served, whole[: len(whole) // 2])


def send_and_go(served, asked):
    """Send a whole call and go away without reading the answer."""
    _send_bytes(served, _on_the_wire(asked))


def send_to_the_dying(served, asked):
    """Send a call to an API process that may die of it."""
    with served.client() as client:
        try:
            send(client, asked)
        except httpx.TransportError:
            return


def settle(served):
    """Wait until the server has seen all that was sent to it, and is at no call any more."""
    # Connections are accepted in their order: when this one is answered, those before were seen.
    with _connection(served) as probe:
        probe.sendall(_PROBE)
        while probe.recv(4096):
            pass
    deadline = time.monotonic() + PATIENCE_S
    while served.server.server_state.tasks:
        assert time.monotonic() < deadline, "calls that do not end"
        time.sleep(0.001)


def _on_the_wire(asked):
    headers = {
        "Host": "station",
        "Authorization": f"Bearer {ADMIN_KEY}",
        "Content-Length": str(len(asked.content)),
        **_AS_JSON,
        **asked.headers,
    }
    lines = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
    return f"{asked.method} {asked.path} HTTP/1.1\r\n{lines}\r\n".encode() + asked.content


def _send_bytes(served, content):
    with _connection(served) as connection:
        connection.sendall(content)


def _connection(served):
    address = urlsplit(served.url)
    return socket.create_connection((address.hostname, address.port), PATIENCE_S)
