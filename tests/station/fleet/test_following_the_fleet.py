"""Shows that a station works on for as long as its fleet is away, and catches up afterwards."""

import threading
from datetime import UTC, datetime, timedelta

import pytest
from fleet_stations import NEVER, Sending, counts
from newest_schema import make_store

from station.errors import StoreUnusable
from station.fleet import (
    Fleet,
    FleetPlaces,
    Follower,
    Pushed,
    follow_fleet,
    migrate_fleet,
    read_note,
)
from station.operations import DataLayout
from station.settings import FleetSettings, SensorSettings, StationSettings
from station.store import Store, sqlite_url
from station.store.changes import ChangesLeft, changes_after

NOTHING = Pushed(number=7, changes=0, rows=0, left=ChangesLeft(0, None))


class Fate:
    """A round that fails as long as it is told to, at times that the test sets."""

    def __init__(self):
        self.error = None
        self.now = datetime(2026, 7, 1, tzinfo=UTC)

    def push(self, _stop):
        if self.error is not None:
            raise self.error
        return NOTHING

    def follower(self, folder):
        return Follower(self.push, folder, every_s=10.0, longest_pause_s=60.0, now=lambda: self.now)


def test_rounds_come_seldomer_while_the_fleet_is_away_and_as_before_when_it_is_back(tmp_path):
    fate = Fate()
    follower = fate.follower(tmp_path)
    assert follower.round(NEVER) == 10.0
    fate.error = StoreUnusable("away")
    assert [follower.round(NEVER) for _ in range(8)] == [1, 2, 4, 8, 16, 32, 60, 60]
    fate.error = None
    assert follower.round(NEVER) == 10.0
    fate.error = StoreUnusable("away")
    assert follower.round(NEVER) == 1.0


def test_no_failure_of_a_round_ends_the_sending(tmp_path):
    fate = Fate()
    follower = fate.follower(tmp_path)
    for fate.error in (RuntimeError("a defect"), MemoryError(), OSError("disk")):
        follower.round(NEVER)
        assert "failed unexpectedly" in read_note(tmp_path).why


def test_the_note_tells_since_when_and_why_and_outlives_the_process(tmp_path):
    fate = Fate()
    began = fate.now
    fate.follower(tmp_path).round(NEVER)
    fate.now += timedelta(days=4)
    fate.error = StoreUnusable("away")
    fate.follower(tmp_path).round(NEVER)
    note = read_note(tmp_path)
    assert (note.since, note.reached_at, note.number, note.why) == (began, began, 7, "away")


@pytest.mark.parametrize("text", ["", "{", "[]", '{"since": 3}'])
def test_a_damaged_note_is_none(tmp_path, text):
    (tmp_path / "fleet.json").write_text(text)
    assert read_note(tmp_path) is None


@pytest.fixture
def settings(tmp_path):
    sensor = SensorSettings(id="left", address="127.0.0.2")
    fleet = FleetSettings(station="north", every_s=0.1, longest_pause_s=1.0)
    found = StationSettings(name="North", data_dir=tmp_path, sensors=(sensor,), fleet=fleet)
    make_store(DataLayout.of(found).store_url)
    return found


@pytest.fixture
def north(settings):
    store = Store.open(DataLayout.of(settings).store_url)
    yield Sending(store, None, "north")
    store.close()


class Following:
    """The sending of a station, in a thread of its own."""

    def __init__(self, settings, url):
        self.settings = settings
        self.fleet = settings.fleet.model_copy(update={"url": url})
        layout = DataLayout.of(settings)
        self.places = FleetPlaces(layout.store_url, layout.root, layout.processes_lock)

    def __enter__(self):
        self.stop = threading.Event()
        self.thread = threading.Thread(
            target=follow_fleet, args=(self.settings, self.fleet, self.places, self.stop)
        )
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        self.thread.join(30.0)
        assert not self.thread.is_alive()

    def until(self, condition, seconds=30.0):
        """Wait until the note is so."""
        for _ in range(int(seconds / 0.05)):
            note = read_note(self.settings.data_dir)
            if note is not None and condition(note):
                return
            self.stop.wait(0.05)
        raise AssertionError(read_note(self.settings.data_dir))


def test_hours_of_passes_without_the_fleet_come_when_it_is_there(settings, north, tmp_path):
    url = sqlite_url(tmp_path / "fleet.sqlite")
    with Following(settings, url) as following:
        following.until(lambda note: note.why is not None and "fleet init" in note.why)
        for number in range(60):  # a train every six minutes
            north.train(number, axles=1)
        migrate_fleet(url)
        following.until(lambda note: note.number >= 60)
    fleet = Fleet.open(url)
    assert counts(fleet) == (60, 60, 60)
    fleet.close()


def test_a_database_that_crashes_in_the_middle_takes_nothing_with_it(settings, north, postgres):
    url = postgres.empty_database()
    migrate_fleet(url)
    with Following(settings, url) as following:
        try:
            for number in range(8):
                north.train(number)
                if number == 4:
                    postgres.crash()
            following.until(lambda note: note.why is not None)
        finally:
            postgres.start()
        north.train(8)
        following.until(lambda note: note.why is None and note.number >= last(north))
    fleet = Fleet.open(url)
    assert counts(fleet) == (9, 18, 18)
    fleet.close()


def last(station):
    with station.store.look() as session:
        return max(row.number for row in changes_after(session, 0, limit=1000))


def test_the_stations_store_is_not_written_to_while_the_fleet_is_away(settings, north, tmp_path):
    north.train(0)
    revisions = north.store.revisions()
    before = revisions.now()
    with Following(settings, sqlite_url(tmp_path / "no" / "fleet.sqlite")) as following:
        following.until(lambda note: note.why is not None)
        following.stop.wait(1.2)  # another try
    assert revisions.now() is before
    revisions.close()
