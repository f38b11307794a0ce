"""One connection to a station, on which every call is made until it is answered.

Each call may come twice without harm: a PUT names what it makes, a POST carries an Idempotency-Key
of its own.  So a call that nobody answered is simply made again, with the same key.
"""

import random
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

import httpx

from station.errors import StationError

Answer = dict[str, Any]
Content = Callable[[], Iterator[bytes]]
"""A body that is sent piece by piece; called once for each time it is sent."""

_LATER = frozenset({429, 503})
_UNDER_WAY = "urn:treadline:problem:CallInProgress"


class CallRefused(StationError):
    """The station refused a call; the message is the detail of its problem document."""

    def __init__(self, status: int, detail: str, problem: Answer | None = None) -> None:
        super().__init__(f"HTTP {status}: {detail}")
        self.status = status
        self.problem = problem or {}
        """The whole document: `type` says for programs what happened, `state` what forbade it."""


class StationUnreachable(StationError):
    """Nobody answered for as long as the patience lasts."""


@dataclass(frozen=True, slots=True)
class Patience:
    """How long a call is made again, and when.

    Attributes
    ----------
    within_s
        No call is made again later than so long after the first time, s; 0 makes each once.
    first_s
        Pause before the second time, s; each further one is twice as long, with a random part so
        that many controllers do not come at once.
    longest_s
        The longest pause, s.

    Raises
    ------
    ValueError
        If one is negative, or the first pause is the longest.
    """

    within_s: float = 30.0
    first_s: float = 0.1
    longest_s: float = 5.0

    def __post_init__(self) -> None:
        if not (self.within_s >= 0.0 and 0.0 < self.first_s <= self.longest_s):
            raise ValueError(f"{self}: within_s >= 0 and 0 < first_s <= longest_s are allowed")

    def pause_s(self, tries: int, asked_s: float | None, chance: float) -> float:
        """Return the pause after so many tries; what the station asked for where it did.

        >>> Patience().pause_s(3, None, 0.5), Patience().pause_s(1, 2.0, 0.5)
        (0.3, 2.0)
        """
        if asked_s is not None:
            return asked_s
        longest: float = min(self.first_s * 2.0 ** float(tries - 1), self.longest_s)
        return round(longest * (0.5 + 0.5 * chance), 6)


class Connection:
    """Makes calls on an HTTP client of a station, again where that is sure to help."""

    def __init__(
        self,
        http: httpx.Client,
        patience: Patience,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        chance: Callable[[], float] = random.random,
    ) -> None:
        self._http = http
        self._patience = patience
        self._clock = clock
        self._sleep = sleep
        self._chance = chance

    def answers(self, path: str) -> bool:
        """Tell whether a path is answered well, once and now; False where nobody answers."""
        try:
            return self._http.get(path).is_success
        except httpx.TransportError:
            return False

    def call(
        self,
        method: str,
        path: str,
        body: Answer | None = None,
        *,
        params: Mapping[str, Any] | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> Answer:
        """Make a call and return its answer; see `send`."""
        answer: Answer = self.send(method, path, body, params=params, headers=headers).json()
        return answer

    def send(
        self,
        method: str,
        path: str,
        body: Answer | None = None,
        *,
        params: Mapping[str, Any] | None = None,
        headers: Mapping[str, str] | None = None,
        content: Content | None = None,
    ) -> httpx.Response:
        """Make a call until it is answered, within the patience.

        Raises
        ------
        CallRefused
            If the station refuses it.
        StationUnreachable
            If nobody answers.
        """
        own = {"Idempotency-Key": uuid4().hex} if method == "POST" else {}
        sent = {**own, **(headers or {})}
        given = {name: value for name, value in (params or {}).items() if value is not None}

        def once() -> httpx.Response:
            return self._http.request(
                method,
                path,
                json=body,
                content=None if content is None else content(),
                params=given or None,
                headers=sent,
            )

        return self._until_answered(once)

    @contextmanager
    def streaming(self, path: str) -> Generator[httpx.Response]:
        """Open an answer that comes bit by bit; it is made again until it begins."""

        def once() -> httpx.Response:
            request = self._http.build_request("GET", path)
            reply = self._http.send(request, stream=True)
            if reply.is_error:
                reply.read()
            return reply

        reply = self._until_answered(once)
        try:
            yield reply
        finally:
            reply.close()

    def breathe(self) -> None:
        """Wait for the first pause."""
        self._sleep(self._patience.first_s)

    def _until_answered(self, once: Callable[[], httpx.Response]) -> httpx.Response:
        until_s = self._clock() + self._patience.within_s
        tries = 0
        while True:
            tries += 1
            asked_s: float | None = None
            try:
                reply = once()
                if not _wants_again(reply):
                    return _ensured(reply)
                asked_s = _asked_s(reply)
                failed: StationError = _refusal(reply)
            except httpx.TransportError as error:
                failed = StationUnreachable(
                    f"{self._http.base_url}: {error or type(error).__name__}; is the station "
                    "running, and the address right?"
                )
            pause_s = self._patience.pause_s(tries, asked_s, self._chance())
            if self._clock() + pause_s > until_s:
                raise failed
            self._sleep(pause_s)


def _wants_again(reply: httpx.Response) -> bool:
    """Tell whether the same call may be taken later, without anybody having to look."""
    if reply.is_success:
        return False
    return reply.status_code in _LATER or _problem(reply).get("type") == _UNDER_WAY


def _asked_s(reply: httpx.Response) -> float | None:
    said = reply.headers.get("Retry-After", "")
    return float(said) if said.isdigit() else None


def _ensured(reply: httpx.Response) -> httpx.Response:
    if reply.is_success:
        return reply
    raise _refusal(reply)


def _refusal(reply: httpx.Response) -> CallRefused:
    problem = _problem(reply)
    return CallRefused(reply.status_code, str(problem.get("detail", reply.text[:200])), problem)


def _problem(reply: httpx.Response) -> Answer:
    try:
        found = reply.json()
    except ValueError:  # of a proxy in between, perhaps
        return {}
    return found if isinstance(found, dict) else {}
