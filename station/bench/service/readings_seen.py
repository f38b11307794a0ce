"""When the readings of wheels can be had, counted from the last frame of each."""

import http.client
import json
import threading
import time
from dataclasses import dataclass, field
from datetime import datetime
from types import TracebackType
from typing import Any, Self

from station.bench.service.trains_by import RATE_HZ

_LOOK_S = 0.05
_PATIENCE_S = 10.0


@dataclass(slots=True)
class ReadingsSeen:
    """While the block runs, asks for the readings of a pass and notes when a new one is there.

    The simulated camera's clock is this host's, so that the two moments can be compared.
    """

    port: int
    key: str
    pass_id: str
    late_s: list[float] = field(default_factory=list, init=False)
    """Of each reading: how long after the last frame of its wheel it was seen."""
    _after: int = field(default=0, init=False)
    _enough: threading.Event = field(default_factory=threading.Event, init=False)
    _thread: threading.Thread = field(init=False)
    _connection: http.client.HTTPConnection = field(init=False)

    def __enter__(self) -> Self:
        self._connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=_PATIENCE_S)
        while self._new():
            pass  # what is there already
        self._thread = threading.Thread(target=self._watch, name="readings", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._enough.set()
        self._thread.join()
        self._connection.close()

    def _watch(self) -> None:
        while not self._enough.wait(_LOOK_S):
            found = self._new()
            seen_s = time.time()
            self.late_s += [seen_s - _last_frame_s(row["wheel"]) for row in found]

    def _new(self) -> list[dict[str, Any]]:
        """Return the readings that have come since the last time."""
        place = f"/v1/measurements?pass={self.pass_id}&after={self._after}"
        self._connection.request("GET", place, headers={"Authorization": f"Bearer {self.key}"})
        found: list[dict[str, Any]] = json.load(self._connection.getresponse())["measurements"]
        if found:
            self._after = found[-1]["id"]
        return found


def _last_frame_s(wheel: dict[str, Any]) -> float:
    """Return when the last frame of a wheel was exposed, UTC; its `time` is of the chosen one."""
    chosen_s = datetime.fromisoformat(wheel["time"]).timestamp()
    return chosen_s + float(max(wheel["frames"]) - wheel["frame"]) / RATE_HZ
