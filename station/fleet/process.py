"""The process that sends what the station knows to its fleet.

A process of its own, behind all others: a database that hangs, or a library that eats memory over a
slow link, is then nothing to the worker, whose threads measure.
"""

import os
import signal
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from station.errors import InputUnusable
from station.fleet.connecting import Fleet, ensure_given
from station.fleet.following import Follower, Stop
from station.fleet.migrating import ensure_ready
from station.fleet.pushing import Pushed, Pusher
from station.limits import limits_of
from station.processes.beginning import begin_process
from station.processes.lifeline import end_with_parent
from station.processes.stop_signal import StopSignal
from station.settings import FleetSettings, StationSettings
from station.store import Store

_BEHIND_ALL = 10


@dataclass(frozen=True, slots=True)
class FleetPlaces:
    """Where the station keeps what the process needs: its store, the note's folder, the lock.

    Told by who starts it: who asks for the layout loads what a process that measures needs.
    """

    store_url: str
    folder: Path
    lock: Path


def begin_fleet(settings: StationSettings, places: FleetPlaces, supervisor_pid: int) -> None:
    """Be the process that sends to the fleet, until SIGTERM or the supervisor's end.

    Raises
    ------
    InputUnusable
        If the settings name no fleet.
    """
    end_with_parent(supervisor_pid)
    # Ctrl-C at a terminal reaches every process; in which order they end is the supervisor's.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    begin_process("fleet", settings.log_level, places.lock)
    os.nice(_BEHIND_ALL)
    if settings.fleet is None:
        raise InputUnusable("the settings name no [fleet]")
    follow_fleet(settings, settings.fleet, places, StopSignal((signal.SIGTERM,)))


def follow_fleet(
    settings: StationSettings, fleet: FleetSettings, places: FleetPlaces, stop: Stop
) -> None:
    """Send to the fleet until told to stop, whether it is there or not."""
    link = _Link(settings, fleet, places.store_url)
    follower = Follower(
        link.push,
        places.folder,
        every_s=fleet.every_s,
        longest_pause_s=fleet.longest_pause_s,
        now=_utc_now,
    )
    try:
        follower.follow(stop)
    finally:
        link.close()


def _utc_now() -> datetime:
    return datetime.now(UTC)


class _Link:
    """The way from the store to the fleet, looked at anew whenever it was cut."""

    def __init__(self, settings: StationSettings, fleet: FleetSettings, store_url: str) -> None:
        self._url = fleet.url
        self._store = Store.open(store_url)
        self._fleet: Fleet | None = None
        self._station = fleet.station or settings.name
        self._name = settings.name
        self._limits = limits_of(settings.limits)
        self._profiles = fleet.profiles

    def push(self, stop: Stop) -> Pushed:
        """Make a round."""
        if self._fleet is None:
            url = ensure_given(self._url)
            ensure_ready(url, stop=stop)
            self._fleet = Fleet.open(url, stop=stop)
        pusher = Pusher(
            self._store,
            self._fleet,
            station=self._station,
            name=self._name,
            limits=self._limits,
            profiles=self._profiles,
            now=_utc_now,
        )
        try:
            return pusher.push(stop)
        except Exception:  # whatever it was goes on to who asked; here the connection is let go
            # Its schema may be another when it is back.
            self._fleet.close()
            self._fleet = None
            raise

    def close(self) -> None:
        """Give all connections back."""
        self._store.close()
        if self._fleet is not None:
            self._fleet.close()
