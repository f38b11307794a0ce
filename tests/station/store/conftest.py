import pytest
from newest_schema import make_store

from station.store import Store, sqlite_url


@pytest.fixture
def store(any_url):
    """An empty store, of each kind in turn."""
    make_store(any_url)
    store = Store.open(any_url)
    yield store
    store.close()


@pytest.fixture
def sqlite_store(tmp_path):
    url = sqlite_url(tmp_path / "station.sqlite")
    make_store(url)
    store = Store.open(url)
    yield store
    store.close()
