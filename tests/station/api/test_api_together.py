"""Shows that twenty clients at a time get through the real API, on both databases: no call fails
for the others' sake, no update is lost, and no two recordings of a sensor run at once."""

import threading
from collections import Counter

import pytest
from served_station import Served

from station.store import Activation, Calibration, CalibrationState, Pass, migrate
from station.store.lists import audit_page
from station.store.watched import counts_by_state

CLIENTS = 20
LIMIT = 1000


@pytest.fixture
def served_on(tmp_path, any_url):
    migrate(any_url)
    served = Served(tmp_path, None, store_url=any_url)
    with served.store.change() as session:
        for name in ("c1", "c2"):
            session.add(
                Calibration(
                    id=name,
                    state=CalibrationState.READY,
                    sensor="left",
                    target="dots:7x8:12",
                    method="joint",
                    recording_ids={"recordings": [], "laser_off": []},
                    created_at=served.station.now(),
                    job_id="j",
                    document="{}",
                )
            )
    yield served
    served.close()


class Client:
    """One of the twenty: it does a bit of everything, and counts what came of it."""

    def __init__(self, served, name):
        self.name = name
        self.counts = Counter()
        self.wrong = []
        self._call = served.client()

    def work(self, rounds):
        with self._call:
            for n in range(rounds):
                self._activate(n)
                self._take_a_pass(f"{self.name}-{n}")
                self._answer("GET", "/v1/measurements", {200})
                self._answer("GET", "/v1/recordings", {200})

    def _answer(self, method, path, allowed, **given):
        answer = self._call.request(method, path, **given)
        self.counts[f"{method} {answer.status_code}"] += 1
        if answer.status_code not in allowed:
            self.wrong.append((method, path, answer.status_code, answer.text))
        return answer

    def _activate(self, n):
        path = "/v1/sensors/left/active-calibration"
        present = self._answer("GET", path, {200, 404})
        match = {"If-Match": present.headers["ETag"]} if present.status_code == 200 else {}
        body = {"calibration": f"c{1 + n % 2}"}
        done = self._answer("PUT", path, {200, 412, 428}, json=body, headers=match)
        self.counts["activated"] += done.status_code == 200

    def _take_a_pass(self, name):
        opened = self._answer("PUT", f"/v1/passes/{name}", {201, 409}, json={"train": "T"})
        if opened.status_code == 201:
            self.counts["passes"] += 1
            self._answer("POST", f"/v1/passes/{name}/finish", {200}, json={"axles": 4})


def all_at_once(served, rounds):
    clients = [Client(served, f"client-{n}") for n in range(CLIENTS)]
    threads = [threading.Thread(target=client.work, args=(rounds,)) for client in clients]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [wrong for client in clients for wrong in client.wrong] == []
    return sum((client.counts for client in clients), Counter())


def check(served, rounds):
    counts = all_at_once(served, rounds)
    with served.store.look() as session:
        versions = [row.version for row in session.query(Activation).order_by(Activation.version)]
        states = counts_by_state(session, Pass)
        trail = Counter(row.action for row in audit_page(session, limit=100 * LIMIT).rows)
    # Each version was given once, and each answer 200 gave one.
    assert versions == list(range(1, counts["activated"] + 1))
    assert counts["activated"] >= rounds
    assert sum(states.values()) == counts["passes"] >= rounds
    assert set(states) <= {"done", "measuring", "recorded"}
    assert trail["activate"] == counts["activated"]
    assert trail["arm"] == trail["finish"] == counts["passes"]
    # A plan was given to a sensor only when the one before had been ended: the double refuses.
    assert len(served.captures["left"].plans) == counts["passes"]


def test_twenty_clients_at_a_time_lose_nothing(served_on):
    check(served_on, rounds=3)


@pytest.mark.slow
def test_twenty_clients_at_a_time_lose_nothing_for_long(served_on):
    check(served_on, rounds=30)
