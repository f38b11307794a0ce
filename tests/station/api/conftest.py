"""The real API, on a real store and socket, for every test; what it is made of is beside."""

import pytest
from served_station import Served, end_servers_at_once

from station.operations import DataLayout
from station.serve import log_as
from station.store import migrate
from station.viewing import Viewer


@pytest.fixture(scope="session", autouse=True)
def _plain_logs():
    # The library's own default draws every traceback in colour, which takes seconds.
    log_as("test")


@pytest.fixture(scope="session", autouse=True)
def _hasty_servers():
    with pytest.MonkeyPatch.context() as monkeypatch:
        end_servers_at_once(monkeypatch)
        yield


class SharedViewer(Viewer):
    """Outlives the stations of the tests: each would start a viewing process, for a second."""

    def close(self):
        pass


@pytest.fixture(scope="session", autouse=True)
def _one_viewing_process(tmp_path_factory):
    shared = SharedViewer("info", tmp_path_factory.mktemp("viewing") / "processes.lock")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("station.api.app.Viewer", lambda *_: shared)
        yield
    Viewer.close(shared)


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
