"""Shows that a fleet that hangs, and does not even say no, holds up neither station nor stopping.

A real PostgreSQL is made to stand still by SIGSTOP: its kernel goes on to acknowledge what is sent,
as a proxy that swallows does.
"""

import os
import signal
import socket
import threading
import time
from contextlib import contextmanager

import pytest
from fleet_stations import NEVER, Sending, counts
from newest_schema import make_store
from sqlalchemy import text

from station.errors import StoreUnusable
from station.fleet import Fleet, ensure_ready, migrate_fleet, patience
from station.store import Store, sqlite_url

PATIENCE_S = 30.0


@pytest.fixture
def north(tmp_path):
    make_store(sqlite_url(tmp_path / "north.sqlite"))
    store = Store.open(sqlite_url(tmp_path / "north.sqlite"))
    yield Sending(store, None, "north")
    store.close()


@pytest.fixture
def url(postgres):
    url = postgres.empty_database()
    migrate_fleet(url)
    return url


@contextmanager
def standing_still(postgres, fleet):
    """Stop the server, and its process that serves the fleet's one connection, in the pool."""
    with fleet.look() as session:
        pids = [session.scalar(text("SELECT pg_backend_pid()")), postgres.pid]
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    try:
        yield
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGCONT)


@pytest.fixture
def hurry(monkeypatch):
    """Have a second of patience be over in a hundredth, from the moment it is called."""

    def begin():
        monkeypatch.setattr(patience, "monotonic", lambda: 100.0 * time.monotonic())

    yield begin
    monkeypatch.undo()


def test_a_server_that_stands_still_is_given_up_and_caught_up_with_later(
    north, postgres, url, hurry, monkeypatch
):
    fleet = Fleet.open(url)
    north.train(0)
    north.push(fleet)
    with standing_still(postgres, fleet):
        hurry()
        # First of the connection there was, then of a new one.
        with pytest.raises(StoreUnusable, match="no answer within 10 s"):
            north.push(fleet)
        north.train(1)  # nothing of the station's is held meanwhile
    monkeypatch.undo()
    north.push(fleet)
    assert counts(fleet) == (2, 4, 4)
    fleet.close()


def test_a_server_that_stops_in_the_middle_of_a_batch_has_none_of_it(url, hurry, monkeypatch):
    fleet = Fleet.open(url)
    with pytest.raises(StoreUnusable, match="no answer within 65 s"):
        begin_and_hang(fleet, hurry)
    monkeypatch.undo()
    with fleet.look() as session:
        assert session.scalar(text("SELECT count(*) FROM fleet_stations")) == 0
    fleet.close()


def begin_and_hang(fleet, hurry):
    with fleet.change() as session:
        session.execute(text("INSERT INTO fleet_stations VALUES ('x','x','x',now(),now(),0,0)"))
        pid = session.scalar(text("SELECT pg_backend_pid()"))
        os.kill(pid, signal.SIGSTOP)
        hurry()
        try:
            session.execute(text("SELECT 1"))
        finally:
            os.kill(pid, signal.SIGCONT)


class Waiting:
    """Who waits for the fleet in a thread, and what is said when it ends."""

    def __init__(self, wait, stop):
        self.stop = stop
        self.error = None
        self._thread = threading.Thread(target=self._run, args=(wait,))
        self._thread.start()

    def _run(self, wait):
        try:
            wait()
        except StoreUnusable as error:
            self.error = str(error)

    def stopped(self):
        assert self._thread.is_alive()
        self.stop.set()
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()


def test_told_to_stop_it_does_not_wait_for_a_server_that_stands_still(north, postgres, url):
    stop = threading.Event()
    fleet = Fleet.open(url, stop=stop)
    north.push(fleet)
    with standing_still(postgres, fleet):
        pushing = Waiting(lambda: north.push(fleet, stop), stop)
        pushing.stopped()
    assert "told to stop" in pushing.error  # and not after a minute: "no answer within 65 s"
    fleet.close()


@contextmanager
def swallowing():
    """A server on TCP that takes all and answers nothing; and what is set once somebody came."""
    came = threading.Event()
    taken = []
    with socket.create_server(("127.74.0.1", 0)) as listening:

        def take():
            while True:
                try:
                    taken.append(listening.accept()[0])
                except OSError:
                    return
                came.set()

        thread = threading.Thread(target=take)
        thread.start()
        try:
            yield f"postgresql://x@127.74.0.1:{listening.getsockname()[1]}/x", came
        finally:
            listening.shutdown(socket.SHUT_RDWR)
            thread.join(PATIENCE_S)
            for each in taken:
                each.close()


def test_told_to_stop_it_does_not_wait_for_a_connection_either():
    with swallowing() as (url, came):
        stop = threading.Event()
        asking = Waiting(lambda: ensure_ready(url, stop=stop), stop)
        assert came.wait(PATIENCE_S)
        asking.stopped()
    assert "told to stop" in asking.error


def test_a_proxy_that_swallows_everything_is_known_within_seconds(hurry):
    with swallowing() as (url, _):
        hurry()
        with pytest.raises(StoreUnusable, match="no answer within 10 s"):
            ensure_ready(url, stop=NEVER)
