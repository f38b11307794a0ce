"""Following a job: what the station sends of it as it changes, on connection after connection."""

import json
from collections.abc import Iterable, Iterator

import httpx

from station.client.connection import Answer, Connection

ENDED = frozenset({"done", "failed", "recovered", "cancelled"})


def follow(connection: Connection, path: str) -> Iterator[Answer]:
    """Yield a job whenever it has changed, until it has ended; a lost connection is made again.

    Raises
    ------
    CallRefused, StationUnreachable
        As every call.
    """
    last: Answer = {}
    while last.get("state") not in ENDED:
        try:
            with connection.streaming(path) as reply:
                for job in _data_of(reply.iter_lines()):
                    if job != last:
                        last = job
                        yield job
        except httpx.TransportError:
            pass  # the next connection begins with where the job is by then
        if last.get("state") not in ENDED:
            connection.breathe()


def _data_of(lines: Iterable[str]) -> Iterator[Answer]:
    """Yield what the events carry.

    >>> list(_data_of(["event: job", 'data: {"state": "done"}', "", ": still at it"]))
    [{'state': 'done'}]
    """
    for line in lines:
        name, _, value = line.partition(":")
        if name == "data":
            yield json.loads(value)
