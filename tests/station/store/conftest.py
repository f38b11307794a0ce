import pytest

from station.store import Store, migrate, sqlite_url


@pytest.fixture
def store(any_url):
    """An empty store, of each kind in turn."""
    migrate(any_url)
    store = Store.open(any_url)
    yield store
    store.close()


@pytest.fixture
def sqlite_store(tmp_path):
    url = sqlite_url(tmp_path / "station.sqlite")
    migrate(url)
    store = Store.open(url)
    yield store
    store.close()
