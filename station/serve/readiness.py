"""Saying when the station is ready, and what it still waits for when that takes long."""

import http.client
import json
import ssl
import threading
import time
from collections.abc import Callable
from urllib.parse import urlsplit

import structlog

from station.processes.stop_signal import StopSignal
from station.serve.service_manager import ServiceManager

_LOOK_EVERY_S = 0.2
_LOOK_LASTS_S = 2.0
_COMPLAIN_EVERY_S = 10.0
_log = structlog.get_logger()

Announce = Callable[[str, float], None]
"""Called with the URL and the seconds it took."""


def begin_announcing(
    url: str, announce: Announce, stop: StopSignal, manager: ServiceManager
) -> None:
    """Watch, beside the supervisor, until every part is ready; then announce it.

    The service manager is told as soon as the API answers: a camera that is away is no reason to
    end the station, which records with the others.
    """
    watcher = threading.Thread(
        target=_watch, args=(url, announce, stop, manager), name="readiness", daemon=True
    )
    watcher.start()


def _watch(url: str, announce: Announce, stop: StopSignal, manager: ServiceManager) -> None:
    began_s = time.monotonic()
    complain_s = began_s + _COMPLAIN_EVERY_S
    told: dict[str, str] | None = None
    while not stop.is_set():
        missing = missing_parts(url)
        if missing != told and "api" not in missing:
            manager.tell_ready()
            manager.tell_status(_status(url, missing))
            told = missing
        if not missing:
            announce(url, time.monotonic() - began_s)
            return
        if time.monotonic() >= complain_s:
            complain_s += _COMPLAIN_EVERY_S
            _log.warning("not ready yet", missing=missing)
        time.sleep(_LOOK_EVERY_S)


def _status(url: str, missing: dict[str, str]) -> str:
    """Return how the station does, in a line.

    >>> _status("http://127.0.0.1:8080", {"left": "unreachable"})
    'serving at http://127.0.0.1:8080; waiting for left (unreachable)'
    """
    waiting = ", ".join(f"{part} ({why})" for part, why in missing.items())
    return f"serving at {url}" + (f"; waiting for {waiting}" if waiting else "")


def missing_parts(url: str) -> dict[str, str]:
    """Return the parts that are not ready, and why; empty when all are."""
    connection = _connection(url)
    try:
        connection.request("GET", "/readyz")
        parts: dict[str, str] = json.load(connection.getresponse())["parts"]
    except (OSError, http.client.HTTPException, ValueError, KeyError):
        return {"api": "does not answer yet"}
    finally:
        connection.close()
    return {part: state for part, state in parts.items() if state != "ready"}


def _connection(url: str) -> http.client.HTTPConnection:
    # Not urllib: it would ask a proxy that the environment names for an address of this host.
    scheme, place = urlsplit(url)[:2]
    if scheme == "http":
        return http.client.HTTPConnection(place, timeout=_LOOK_LASTS_S)
    # The certificate names the host as others call it; this asks the process beside it.
    unchecked = ssl.create_default_context()
    unchecked.check_hostname, unchecked.verify_mode = False, ssl.CERT_NONE
    return http.client.HTTPSConnection(place, timeout=_LOOK_LASTS_S, context=unchecked)
