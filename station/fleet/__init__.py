"""Many stations, one database: each sends what it knows, and the fleet shows it side by side."""

from station.fleet.connecting import Fleet, ensure_given
from station.fleet.following import Follower
from station.fleet.migrating import EMPTY, ensure_ready, fleet_revision, migrate_fleet
from station.fleet.note import FleetNote, read_note
from station.fleet.process import follow_fleet, run_fleet
from station.fleet.pushing import Pushed, Pusher

__all__ = [
    "EMPTY",
    "Fleet",
    "FleetNote",
    "Follower",
    "Pushed",
    "Pusher",
    "ensure_given",
    "ensure_ready",
    "fleet_revision",
    "follow_fleet",
    "migrate_fleet",
    "read_note",
    "run_fleet",
]
