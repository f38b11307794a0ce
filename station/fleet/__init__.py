"""Many stations, one database: each sends what it knows, and the fleet shows it side by side."""

from station.fleet.agreement import Agreement, StationOffset, station_agreement
from station.fleet.connecting import Fleet, ensure_given
from station.fleet.following import Follower
from station.fleet.forecast import Forecast, forecast_of
from station.fleet.migrating import EMPTY, ensure_ready, fleet_revision, migrate_fleet
from station.fleet.note import FleetNote, read_note
from station.fleet.overview import (
    SensorHealth,
    StationState,
    sensor_healths,
    station_states,
)
from station.fleet.process import FleetPlaces, begin_fleet, follow_fleet
from station.fleet.pushing import Pushed, Pusher
from station.fleet.trends import (
    MOST_PASSES,
    FleetQuantity,
    FleetSide,
    FleetTrend,
    FleetValue,
    fleet_trend,
)
from station.fleet.wear import StationValue, Wear, wear_of
from station.fleet.wording import figure, moment, remarks_on, span

__all__ = [
    "EMPTY",
    "MOST_PASSES",
    "Agreement",
    "Fleet",
    "FleetNote",
    "FleetPlaces",
    "FleetQuantity",
    "FleetSide",
    "FleetTrend",
    "FleetValue",
    "Follower",
    "Forecast",
    "Pushed",
    "Pusher",
    "SensorHealth",
    "StationOffset",
    "StationState",
    "StationValue",
    "Wear",
    "begin_fleet",
    "ensure_given",
    "ensure_ready",
    "figure",
    "fleet_revision",
    "fleet_trend",
    "follow_fleet",
    "forecast_of",
    "migrate_fleet",
    "moment",
    "read_note",
    "remarks_on",
    "sensor_healths",
    "span",
    "station_agreement",
    "station_states",
    "wear_of",
]
