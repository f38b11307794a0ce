"""The real API, on a real store and socket, for every test; what it is made of is beside."""

import pytest
from served_station import Served

from station.operations import DataLayout
from station.serve import log_as
from station.store import migrate


@pytest.fixture(scope="session", autouse=True)
def _plain_logs():
    # The library's own default draws every traceback in colour, which takes seconds.
    log_as("test")


@pytest.fixture(scope="session")
def empty_store(tmp_path_factory):
    root = tmp_path_factory.mktemp("empty")
    migrate(DataLayout(root).store_url)
    return root / "station.sqlite"


@pytest.fixture
def served(request, tmp_path, empty_store):
    """Serve a station; what a test gives as parameter is put in place of its settings."""
    served = Served(tmp_path, empty_store, **getattr(request, "param", {}))
    yield served
    served.close()


@pytest.fixture
def call(served):
    with served.client() as client:
        yield client
