import pytest

from station.store import Store, migrate, sqlite_url


@pytest.fixture
def url(tmp_path):
    return sqlite_url(tmp_path / "station.sqlite")


@pytest.fixture
def store(url):
    migrate(url)
    store = Store.open(url)
    yield store
    store.close()
