"""Makes what the folders below share importable, and gives them databases of both kinds."""

import numpy as np
import pytest
from postgres_server import PostgresServer, initdb

from station.store import sqlite_url


@pytest.fixture(scope="session")
def postgres():
    program = initdb()
    if program is None:
        pytest.skip("no PostgreSQL on this host; deploy/test installs it")
    server = PostgresServer(program.parent)
    yield server
    server.stop()


@pytest.fixture
def once(monkeypatch):
    """Have locks that are held be tried once: waiting two seconds for them shows nothing more."""
    monkeypatch.setattr("station.processes.lock._PAUSE_S", 10.0)


@pytest.fixture(params=["sqlite", "postgresql"])
def any_url(request, tmp_path):
    """The URL of an empty database, of each kind in turn."""
    if request.param == "sqlite":
        return sqlite_url(tmp_path / "station.sqlite")
    return request.getfixturevalue("postgres").empty_database()


@pytest.fixture(scope="session")
def rig_shots():
    """Two shots of one wheel, each the pictures of both sensors of a rig."""
    # Rendering is loaded by the few tests that see something rendered.
    from rig_recordings import RIG_WHEEL, shots_of  # noqa: PLC0415

    return shots_of(RIG_WHEEL, (-20.0, 10.0), np.random.default_rng(3), seed=7)
