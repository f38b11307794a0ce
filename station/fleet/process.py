"""The process that sends what the station knows to its fleet.

A process of its own, behind all others: a database that hangs, or a library that eats memory over a
slow link, is then nothing to the worker, whose threads measure.
"""

import os
import signal

from station.errors import InputUnusable
from station.fleet.connecting import Fleet, ensure_given
from station.fleet.following import Follower, Stop
from station.fleet.migrating import ensure_ready
from station.fleet.pushing import Pushed, Pusher
from station.limits import limits_of
from station.operations import DataLayout, utc_now
from station.processes.stop_signal import StopSignal
from station.settings import FleetSettings, StationSettings
from station.store import Store

_BEHIND_ALL = 10


def run_fleet(settings: StationSettings) -> None:
    """Send to the fleet until SIGTERM."""
    os.nice(_BEHIND_ALL)
    if settings.fleet is None:
        raise InputUnusable("the settings name no [fleet]")
    follow_fleet(settings, settings.fleet, StopSignal((signal.SIGTERM,)))


def follow_fleet(settings: StationSettings, fleet: FleetSettings, stop: Stop) -> None:
    """Send to the fleet until told to stop, whether it is there or not."""
    layout = DataLayout.of(settings)
    link = _Link(settings, fleet)
    follower = Follower(
        link.push,
        layout.root,
        every_s=fleet.every_s,
        longest_pause_s=fleet.longest_pause_s,
        now=utc_now,
    )
    try:
        follower.follow(stop)
    finally:
        link.close()


class _Link:
    """The way from the store to the fleet, looked at anew whenever it was cut."""

    def __init__(self, settings: StationSettings, fleet: FleetSettings) -> None:
        self._url = fleet.url
        self._store = Store.open(DataLayout.of(settings).store_url)
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
            now=utc_now,
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
