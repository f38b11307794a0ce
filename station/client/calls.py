"""What all calls of the client are made of: lists, waiting, and the places of things."""

import time
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import quote

from station.client.connection import Answer, Connection
from station.client.following import ENDED
from station.errors import StationError

_POLL_S = 0.2


class Calls:
    """Calls on one connection."""

    def __init__(self, connection: Connection) -> None:
        self._at = connection

    def await_job(self, job_id: str, *, timeout_s: float) -> Answer:
        """Wait until a job has ended, and return it."""
        return self._await(place_of("jobs", job_id), timeout_s)

    def _made(self, kind: str, body: Answer, timeout_s: float) -> Answer:
        ordered = self._at.call("POST", f"/v1/{kind}", body)
        self.await_job(ordered["job"], timeout_s=timeout_s)
        return self._at.call("GET", place_of(kind, ordered["id"]))

    def _listed(
        self, path: str, key: str, which: Mapping[str, Any], *, cursor: str = "before"
    ) -> Iterator[Answer]:
        """Yield the rows of a list, page after page."""
        following: str | int | None = None
        while True:
            page = self._at.call("GET", path, params={**which, cursor: following})
            yield from page[key]
            following = page["next"]
            if following is None:
                return

    def _await(self, path: str, timeout_s: float) -> Answer:
        deadline = time.monotonic() + timeout_s
        while True:
            answer = self._at.call("GET", path)
            if _has_ended(answer):
                return answer
            if time.monotonic() > deadline:
                raise StationError(
                    f"{path} is still {answer['state']} after {timeout_s:g} s; look at the "
                    "station's log, or wait longer"
                )
            time.sleep(_POLL_S)


def _has_ended(answer: Answer) -> bool:
    # A pass that stays `recorded` says why: it was cancelled, or nothing was calibrated.
    unmeasured = answer["state"] == "recorded" and bool(answer.get("reason"))
    return answer["state"] in ENDED or unmeasured


def place_of(kind: str, name: str) -> str:
    """Return where one thing of a kind is.

    >>> place_of("passes", "a/b")
    '/v1/passes/a%2Fb'
    """
    return f"/v1/{kind}/{quote(name, safe='')}"
