"""HTTP/1.1 that is not kept waiting: who sends headers drop by drop is cut off."""

import asyncio
import ipaddress
import json
import socket
from collections.abc import Sequence
from typing import ClassVar

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

from station.settings import WebSettings

_LINGER_S = 2.0
"""How long the rest of a body is read and dropped after its call was refused.

A connection closed with bytes unread is reset, and the caller never sees why.
"""


class PatientHttp(H11Protocol):
    """A connection that waits for headers so long and no longer, and is one of so many.

    uvicorn waits for ever: one caller with a thousand open connections would hold all its sockets.
    """

    header_s: ClassVar[float]
    most_connections: ClassVar[int]
    proxies: ClassVar[Sequence[ipaddress.IPv4Network | ipaddress.IPv6Network]]
    _waiting: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        super().connection_made(transport)
        # asyncio sets this itself, but not on a socket that was opened without naming TCP: the
        # body of an answer, written after its headers, then waits 40 ms for the caller's ACK.
        connection = transport.get_extra_info("socket")
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if self._of_the_same_caller() > self.most_connections:
            line = f"you hold {self.most_connections} connections; close some, or use them again"
            self._refuse(503, "Service unavailable", line)
        else:
            self._wait(self.header_s)

    def _of_the_same_caller(self) -> int:
        if self.client is None or self._is_proxy(self.client[0]):
            return 0
        return sum(
            other.client is not None and other.client[0] == self.client[0]
            for other in self.connections
            if isinstance(other, PatientHttp)
        )

    def _is_proxy(self, host: str) -> bool:
        address = ipaddress.ip_address(host)
        return any(address in network for network in self.proxies)

    def connection_lost(self, exc: Exception | None) -> None:
        self._wait(None)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._wait(self._patience_s())

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._wait(self._patience_s())

    def _patience_s(self) -> float | None:
        if self.conn.their_state is h11.IDLE and self.conn.trailing_data[0]:
            return self.header_s
        answered = self.cycle is not None and self.cycle.response_complete
        return _LINGER_S if answered and self.conn.their_state is h11.SEND_BODY else None

    def _wait(self, patience_s: float | None) -> None:
        """Begin to wait where nothing is waited for yet; with None, wait no more."""
        if patience_s is None:
            if self._waiting is not None:
                self._waiting.cancel()
                self._waiting = None
        elif self._waiting is None:
            self._waiting = self.loop.call_later(patience_s, self._give_up)

    def _give_up(self) -> None:
        self._waiting = None
        line = f"the headers were not whole after {self.header_s:g} s; send the call again"
        self._refuse(408, "Request timeout", line)

    def send_400_response(self, msg: str) -> None:
        self._refuse(400, "Bad request", "this is not HTTP/1.1 that can be read; correct the call")

    def _refuse(self, status: int, title: str, detail: str) -> None:
        """Close the connection, with a problem document where nothing was answered yet."""
        if self.transport.is_closing():
            return
        if self.conn.our_state in {h11.IDLE, h11.SEND_RESPONSE}:
            problem = {"type": "about:blank", "title": title, "status": status, "detail": detail}
            headers = [
                (b"content-type", b"application/problem+json"),
                (b"x-content-type-options", b"nosniff"),
                (b"connection", b"close"),
            ]
            events = (
                h11.Response(status_code=status, headers=headers),
                h11.Data(data=json.dumps(problem).encode()),
                h11.EndOfMessage(),
            )
            self.transport.write(b"".join(self.conn.send(event) or b"" for event in events))
        self.transport.close()


def patient_http(web: WebSettings) -> type[PatientHttp]:
    """Return the protocol of a server with the limits of the settings."""
    limits = {
        "header_s": web.header_s,
        "most_connections": web.connections,
        "proxies": web.proxies,
    }
    return type("PatientHttp", (PatientHttp,), limits)
