"""Calls that come when they come: an answer that is late does not hold up the calls after it.

A caller that waits for each answer before it calls again makes no calls while the station stalls,
and the stall is one bad figure in thousands.  Here the moments of the calls are drawn beforehand,
and what a call took is counted from the moment it was due.
"""

import asyncio
import gc
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_CONNECTIONS = 32
_PATIENCE_S = 20.0
_END_OF_HEADERS = b"\r\n\r\n"
_LENGTH = b"content-length:"


@dataclass(frozen=True, slots=True)
class Call:
    """One kind of call, made over and over.

    Attributes
    ----------
    share
        Of all calls; the shares need not add up to anything.
    body
        JSON; empty where the call has none.
    """

    name: str
    method: str
    path: str
    share: float
    body: str = ""

    def as_bytes(self, key: str) -> bytes:
        """Return the call as it goes over the wire."""
        lines = [
            f"{self.method} {self.path} HTTP/1.1",
            "Host: station",
            f"Authorization: Bearer {key}",
        ]
        if self.body:
            lines += ["Content-Type: application/json", f"Content-Length: {len(self.body)}"]
        return "\r\n".join([*lines, "", self.body]).encode()


@dataclass(frozen=True, slots=True)
class Load:
    """What is called where, how often, for how long."""

    port: int
    key: str
    calls: tuple[Call, ...]
    rate_hz: float
    seconds: float
    seed: int = 20240501


@dataclass(frozen=True, slots=True)
class Answered:
    """How one call was answered."""

    name: str
    status: int
    """Of HTTP; 0 where there was no answer."""
    took_ms: float
    """From when it was due to the last byte of the answer."""
    sent_late_ms: float
    """How long after it was due it was sent: no connection was free, or this process slept."""


class _Connection(asyncio.Protocol):
    """One connection, kept open; one call at a time."""

    def __init__(self, caller: "_Caller") -> None:
        self._caller = caller
        self._received = bytearray()
        self._wanted: int | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)  # noqa: S101  for the type checker
        self.transport = transport

    def data_received(self, data: bytes) -> None:
        self._received += data
        if self._wanted is None:
            head, found, _ = self._received.partition(_END_OF_HEADERS)
            if not found:
                return
            self._wanted = len(head) + len(found) + _length_of(bytes(head))
        if len(self._received) >= self._wanted:
            status = int(self._received[9:12])
            self._received.clear()
            self._wanted = None
            self._caller.answered(self, status)

    def connection_lost(self, exc: Exception | None) -> None:
        self._caller.lost(self)


def _length_of(head: bytes) -> int:
    lowered = head.lower()
    place = lowered.index(_LENGTH) + len(_LENGTH)
    return int(lowered[place:].split(b"\r\n", 1)[0])


@dataclass(slots=True)
class _Due:
    """A call and its moments, by the clock of the loop."""

    place: int
    due_s: float
    sent_s: float = 0.0


class _Caller:
    """Sends each call when it is due, or as soon as a connection is free."""

    def __init__(self, load: Load) -> None:
        self._load = load
        self._loop = asyncio.get_running_loop()
        self._bytes = [call.as_bytes(load.key) for call in load.calls]
        self._idle: deque[_Connection] = deque()
        self._waiting: deque[_Due] = deque()
        self._under_way: dict[_Connection, _Due] = {}
        self.results: list[Answered] = []

    async def run(self) -> None:
        """Make all calls, and wait for the last answers."""
        await asyncio.gather(*(self._connect() for _ in range(_CONNECTIONS)))
        began_s = self._loop.time()
        for place, after_s in _moments(self._load):
            due_s = began_s + after_s
            while (early_s := due_s - self._loop.time()) > 0.0:
                await asyncio.sleep(early_s)
            self._waiting.append(_Due(place, due_s))
            self._send_what_waits()
        until_s = self._loop.time() + _PATIENCE_S
        while (self._under_way or self._waiting) and self._loop.time() < until_s:
            await asyncio.sleep(0.01)
        for due in (*self._under_way.values(), *self._waiting):
            self._note(due, status=0)
        for connection in (*self._idle, *self._under_way):
            connection.transport.abort()

    def answered(self, connection: _Connection, status: int) -> None:
        """Take note of an answer; its connection is free for the next call."""
        self._note(self._under_way.pop(connection), status)
        self._idle.append(connection)
        self._send_what_waits()

    def lost(self, connection: _Connection) -> None:
        """Count a call whose connection was closed on it as not answered."""
        due = self._under_way.pop(connection, None)
        if due is not None:
            self._note(due, status=0)
        if connection in self._idle:
            self._idle.remove(connection)

    async def _connect(self) -> None:
        _, connection = await self._loop.create_connection(
            lambda: _Connection(self), "127.0.0.1", self._load.port
        )
        self._idle.append(connection)

    def _send_what_waits(self) -> None:
        while self._waiting and self._idle:
            due, connection = self._waiting.popleft(), self._idle.popleft()
            due.sent_s = self._loop.time()
            self._under_way[connection] = due
            connection.transport.write(self._bytes[due.place])

    def _note(self, due: _Due, status: int) -> None:
        self.results.append(
            Answered(
                name=self._load.calls[due.place].name,
                status=status,
                took_ms=1e3 * (self._loop.time() - due.due_s),
                sent_late_ms=1e3 * (due.sent_s - due.due_s),
            )
        )


def _moments(load: Load) -> Sequence[tuple[int, float]]:
    """Draw which call is due when, s: of callers that know nothing of each other (Poisson)."""
    rng = np.random.default_rng(load.seed)
    count = round(load.rate_hz * load.seconds)
    after_s = np.cumsum(rng.exponential(1.0 / load.rate_hz, count))
    shares = np.array([call.share for call in load.calls])
    places = rng.choice(len(shares), count, p=shares / shares.sum())
    each_once = min(count, len(shares))  # a short load has of each kind, too
    places[:each_once] = np.arange(each_once)
    return list(zip(places.tolist(), after_s.tolist(), strict=True))


@dataclass(frozen=True, slots=True)
class Driven:
    """What came of a load.

    Attributes
    ----------
    core_s
        Processor seconds the calling itself took.
    took_s
        From the first call to the last answer.
    """

    answers: tuple[Answered, ...]
    core_s: float
    took_s: float


def drive(load: Load) -> Driven:
    """Make the calls of a load; the process should have nothing else to do."""
    gc.collect()
    gc.disable()  # a collection here would be counted as the server's
    began_s, began_core_s = time.perf_counter(), time.process_time()

    async def make_calls() -> list[Answered]:
        caller = _Caller(load)
        await caller.run()
        return caller.results

    answers = asyncio.run(make_calls())
    gc.enable()
    return Driven(tuple(answers), time.process_time() - began_core_s, time.perf_counter() - began_s)
