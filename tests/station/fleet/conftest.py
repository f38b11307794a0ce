import pytest
from fleet_stations import Sending
from newest_schema import make_store

from station.fleet import Fleet, migrate_fleet
from station.store import Store, sqlite_url


@pytest.fixture
def fleet(any_url):
    """A fleet's database, of each kind in turn."""
    migrate_fleet(any_url)
    fleet = Fleet.open(any_url)
    yield fleet
    fleet.close()


@pytest.fixture
def station(tmp_path, fleet):
    """Make stations that send to the fleet, each with an empty store of its own."""
    stores = []

    def make(name="north", **how):
        url = sqlite_url(tmp_path / f"{name}.sqlite")
        make_store(url)
        stores.append(Store.open(url))
        return Sending(stores[-1], fleet, name, **how)

    yield make
    for store in stores:
        store.close()
