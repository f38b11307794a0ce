"""What the station tells Prometheus of what it has still to send to its fleet."""

from collections.abc import Iterable

from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from station.api.families import gauge
from station.fleet import read_note
from station.operations import Station
from station.store.changes import changes_left


class FleetCollector(Collector):
    """Counts them in the store; nothing where the station is in no fleet."""

    def __init__(self, station: Station) -> None:
        self._station = station

    def collect(self) -> Iterable[Metric]:
        if self._station.settings.fleet is None:
            return []
        note = read_note(self._station.layout.root)
        with self._station.store.look() as session:
            left = changes_left(session, 0 if note is None else note.number)
        now = self._station.now()
        lag_s = 0.0 if left.since is None else max((now - left.since).total_seconds(), 0.0)
        reached = None if note is None or note.reached_at is None else note.reached_at.timestamp()
        return [
            gauge("station_fleet_lag_rows", "Changes not yet sent to the fleet.", left.count),
            gauge(
                "station_fleet_lag_seconds",
                "How long the oldest of them has waited; 0 where there is none.",
                lag_s,
            ),
            gauge(
                "station_fleet_last_success_timestamp_seconds",
                "When the fleet was reached last and everything new was sent, Unix time.",
                reached,
            ),
            gauge(
                "station_fleet_reached",
                "1 where the last round came to the fleet, 0 where it failed.",
                None if note is None else float(note.why is None),
            ),
        ]
