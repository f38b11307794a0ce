"""Shows what the station tells of its fleet: metrics at once, an alarm after days, its own process.

That an alarm of this gravity makes no part degraded is shown by the lookout's own tests.
"""

import time
from datetime import UTC, datetime, timedelta

import pytest
from fleet_stations import Sending, counts
from newest_schema import make_store
from prometheus_client import CollectorRegistry, generate_latest

from station.api.fleet_metrics import FleetCollector
from station.fleet import Fleet, migrate_fleet, read_note
from station.fleet.note import FleetNote, write_note
from station.operations import DataLayout, Station
from station.serve.processes import start_fleet
from station.serve.supervisor import _stages
from station.settings import FleetSettings, SensorSettings, StationSettings
from station.store import Store, sqlite_url
from station.watching import Lookout, Severity, TroubleKind

NOW = datetime(2026, 7, 10, 12, 0, tzinfo=UTC)


def settings(tmp_path, **more):
    sensor = SensorSettings(id="left", address="127.0.0.2")
    return StationSettings(name="North", data_dir=tmp_path / "data", sensors=(sensor,), **more)


@pytest.fixture
def fleet_url(tmp_path):
    return sqlite_url(tmp_path / "fleet.sqlite")


@pytest.fixture
def station(tmp_path, fleet_url):
    """Make a station of a fleet, or of none; its clock stands."""
    stores = []

    def make(**more):
        found = settings(tmp_path, **{"fleet": FleetSettings(url=fleet_url), **more})
        layout = DataLayout.of(found)
        make_store(layout.store_url)
        stores.append(Store.open(layout.store_url))
        return Station(
            settings=found,
            store=stores[-1],
            layout=layout,
            captures={},
            jobs=None,
            salvage=None,
            now=lambda: NOW,
        )

    yield make
    for store in stores:
        store.close()


def metrics(station):
    registry = CollectorRegistry()
    registry.register(FleetCollector(station))
    lines = generate_latest(registry).decode().splitlines()
    return dict(line.split() for line in lines if not line.startswith("#"))


def fleet_troubles(station):
    outlook = Lookout(station, lambda: True).look()
    return [each for each in outlook.troubles if each.kind is TroubleKind.FLEET_SILENT]


def test_metrics_count_what_is_not_sent_and_since_when(station):
    north = station()
    sending = Sending(north.store, None, "North")
    sending.train(0)
    assert metrics(north)["station_fleet_lag_rows"] == "1.0"
    assert float(metrics(north)["station_fleet_lag_seconds"]) >= 0.0
    note = FleetNote(since=NOW, reached_at=NOW, number=10**6)
    write_note(north.layout.root, note)
    told = metrics(north)
    assert (told["station_fleet_lag_rows"], told["station_fleet_lag_seconds"]) == ("0.0", "0.0")
    assert float(told["station_fleet_last_success_timestamp_seconds"]) == NOW.timestamp()
    assert told["station_fleet_reached"] == "1.0"


def test_a_station_of_no_fleet_tells_nothing_of_one(station):
    alone = station(fleet=None)
    assert metrics(alone) == {}
    assert "fleet" not in Lookout(alone, lambda: True).look().parts


@pytest.mark.parametrize(("days", "alarmed"), [(2.9, False), (3.1, True)])
def test_a_fleet_that_is_away_is_an_alarm_after_days_and_never_a_degraded_part(
    station, days, alarmed
):
    north = station()
    reached = NOW - timedelta(days=days)
    write_note(north.layout.root, FleetNote(reached, reached, 1, why="no route to host"))
    found = fleet_troubles(north)
    assert bool(found) is alarmed
    if alarmed:
        assert found[0].severity is Severity.NOTICE
        assert "no route to host" in found[0].what
    assert Lookout(north, lambda: True).look().part("fleet").condition == "ready"


def test_a_fleet_that_was_never_reached_alarms_too(station):
    north = station()
    write_note(north.layout.root, FleetNote(NOW - timedelta(days=4)))
    assert len(fleet_troubles(north)) == 1


def test_only_a_station_of_a_fleet_runs_the_process(tmp_path, fleet_url):
    def names(**more):
        stages = _stages(settings(tmp_path, **more), tmp_path, lambda: None)
        return [child.name for stage in stages for child in stage]

    assert names() == ["api", "worker", "capture left"]
    of_fleet = names(fleet=FleetSettings(url=fleet_url))
    assert of_fleet == ["api", "worker", "fleet", "capture left"]


def test_the_process_sends_and_ends_when_asked(station, fleet_url):
    migrate_fleet(fleet_url)
    north = station()
    Sending(north.store, None, "North").train(0)
    process = start_fleet(north.settings)
    try:
        until(lambda: (note := read_note(north.layout.root)) is not None and note.reached_at)
        process.terminate()
        process.join(30.0)  # it is behind all others, also in ending
        assert process.exitcode == 0
    finally:
        process.kill()
        process.join()
    fleet = Fleet.open(fleet_url)
    assert counts(fleet, "North") == (1, 2, 2)
    fleet.close()


@pytest.mark.slow
def test_the_process_killed_in_the_middle_of_a_batch_doubles_nothing(station, fleet_url):
    migrate_fleet(fleet_url)
    fleet = Fleet.open(fleet_url)
    north = station()
    sending = Sending(north.store, None, "North")
    for number in range(100):
        sending.train(number, axles=1)
    process = start_fleet(north.settings)
    try:
        until(lambda: counts(fleet)[0] >= 20)
    finally:
        process.kill()
        process.join(30.0)
    # Whole batches, of 20; where it was slower to die than to send there is nothing to see.
    assert counts(fleet)[0] % 20 == 0 or counts(fleet)[0] == 100
    sending.fleet = fleet
    sending.push()
    assert counts(fleet) == (100, 100, 100)
    fleet.close()


def until(reached):
    deadline = time.monotonic() + 30.0
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.01)
