"""The viewing process: it makes one picture after the other, until nobody asks any more."""

import json
import os
from collections import OrderedDict
from dataclasses import asdict
from multiprocessing.connection import Connection
from multiprocessing.reduction import recv_handle
from typing import Any

from calib import CalibError
from station.errors import StationError
from station.processes.on_call import answer_calls
from station.viewing.finding import Finder
from station.viewing.making import content_of
from station.viewing.orders import View, ViewOrder

_MOST_KEPT = 8
"""Made last: several who look at the same time mostly want the same."""
_Key = tuple[Any, ...]


class Desk:
    """Makes what is asked for, and remembers what it made last."""

    def __init__(self, finder: Finder) -> None:
        self._finder = finder
        self._made: OrderedDict[_Key, View] = OrderedDict()

    def view(self, order: ViewOrder) -> View | None:
        """Return what an order asks for; None where the caller has the frame already.

        Raises
        ------
        StationError
            If there is no such frame.
        """
        found = self._finder.find(order)
        number = found.frame.number
        if number is not None and number == order.known:
            return None
        if order.shared is not None:
            return View(found.frame, order.form, content_of(found, order))
        asked = order.form, order.max_width, order.frame_ids, *order.about.items()
        key = (order.recording, number, *asked)
        made = self._made.get(key)
        if made is None:
            made = View(found.frame, order.form, content_of(found, order))
            self._keep(key, made)
        return made

    def _keep(self, key: _Key, made: View) -> None:
        self._made[key] = made
        if len(self._made) > _MOST_KEPT:
            self._made.popitem(last=False)


def serve(link: Connection, desk: Desk, idle_s: float) -> None:
    """Answer order after order, until the asking end is closed or is silent for so long."""
    try:
        while link.poll(idle_s):
            fields = json.loads(link.recv_bytes())
            descriptor = recv_handle(link) if fields["shared"] is not None else None
            try:
                _answer(link, desk, ViewOrder.from_json(fields, descriptor))
            finally:
                if descriptor is not None:
                    os.close(descriptor)
    except (EOFError, ConnectionError):
        return


def _answer(link: Connection, desk: Desk, order: ViewOrder) -> None:
    try:
        made = desk.view(order)
    except (CalibError, StationError) as error:
        # Of `calib` a caller here knows nothing: its errors are the station's from here on.
        kind = type(error).__name__ if isinstance(error, StationError) else StationError.__name__
        _say(link, {"error": kind, "message": str(error)})
        return
    if made is None:
        _say(link, {"same": True})
    else:
        _say(link, {"frame": asdict(made.frame)})
        link.send_bytes(made.content)


def _say(link: Connection, fields: dict[str, Any]) -> None:
    link.send_bytes(json.dumps(fields).encode())


if __name__ == "__main__":
    answer_calls("viewing", lambda link, idle_s: serve(link, Desk(Finder()), idle_s))
