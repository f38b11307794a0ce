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
    """While the block runs, asks for the readings of a pass and notes when each is there first.

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

    def __enter__(self) -> Self:
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

    def _watch(self) -> None:
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=_PATIENCE_S)
        while not self._enough.wait(_LOOK_S):
            self._look(connection)
        self._look(connection)
        connection.close()

    def _look(self, connection: http.client.HTTPConnection) -> None:
        place = f"/v1/measurements?pass={self.pass_id}&after={self._after}"
        connection.request("GET", place, headers={"Authorization": f"Bearer {self.key}"})
        found = json.load(connection.getresponse())["measurements"]
        seen_s = time.time()
        for row in found:
            self._after = row["id"]
            self.late_s.append(seen_s - _last_frame_s(row["wheel"]))


def _last_frame_s(wheel: dict[str, Any]) -> float:
    """Return when the last frame of a wheel was exposed, UTC; its `time` is of the chosen one."""
    chosen_s = datetime.fromisoformat(wheel["time"]).timestamp()
    return chosen_s + float(max(wheel["frames"]) - wheel["frame"]) / RATE_HZ
