"""Shows that an answer is given again only as long as it is true, and only to who may ask."""

import sqlite3
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import pytest
from served_station import Served

from station.store import JobKind, Pass, Store, add_job, migrate
from station.store.callers import Scope


class Looks:
    """Counts how often a station's store is looked into, and holds the looks up when told to."""

    def __init__(self, served):
        self._look = served.store.look
        self.count = 0
        self.gate = threading.Event()
        self.gate.set()
        served.store.look = self._counted

    @contextmanager
    def _counted(self):
        self.count += 1
        assert self.gate.wait(20.0)
        with self._look() as session:
            yield session

    def of(self, make_call):
        before = self.count
        answer = make_call()
        return answer, self.count - before


@pytest.fixture
def looks(served, call):
    call.put("/v1/passes/p1", json={"train": "ICE 1"}).raise_for_status()
    call.get("/v1/passes/p1").raise_for_status()  # the key is known from here on
    return Looks(served)


READS = (
    "/v1/passes",
    "/v1/passes/p1",
    "/v1/passes/p1/wheels",
    "/v1/recordings",
    "/v1/recordings/pass.p1.left",
    "/v1/jobs",
    "/v1/measurements",
    "/v1/measurements?limit=3",
    "/v1/calibration-sessions",
)


@pytest.mark.parametrize("path", READS)
def test_what_is_asked_again_while_nothing_changed_is_not_looked_up_again(call, looks, path):
    first, looked = looks.of(lambda: call.get(path))
    again, looked_again = looks.of(lambda: call.get(path))
    assert first.status_code == again.status_code == 200
    assert first.content == again.content
    assert looked > 0 or path == "/v1/passes/p1"  # which the fixture asked for already
    assert looked_again == 0


def test_an_answer_given_again_has_an_id_and_headers_of_its_own(call, looks):
    first, again = call.get("/v1/passes"), call.get("/v1/passes")
    assert first.headers["X-Request-Id"] != again.headers["X-Request-Id"]
    for name in ("Content-Type", "Cache-Control", "X-Content-Type-Options"):
        assert first.headers[name] == again.headers[name]


def test_a_change_over_the_api_is_seen_by_the_next_call(call, looks):
    assert call.get("/v1/passes/p1").json()["state"] == "recording"
    call.post("/v1/passes/p1/finish", json={"axles": 4}).raise_for_status()
    assert call.get("/v1/passes/p1").json()["state"] == "recorded"


def test_a_change_by_another_process_is_seen_by_the_next_call(served, call, looks):
    assert call.get("/v1/passes/p1").json()["train"] == "ICE 1"
    worker = Store.open(served.layout.store_url)
    with worker.change() as session:
        session.get(Pass, "p1").train = "ICE 2"
    worker.close()
    assert call.get("/v1/passes/p1").json()["train"] == "ICE 2"


def test_what_was_not_there_is_found_once_it_is(call, looks):
    assert call.get("/v1/passes/p2").status_code == 404
    call.post("/v1/passes/p1/finish", json={"axles": 4}).raise_for_status()
    call.put("/v1/passes/p2", json={}).raise_for_status()
    assert call.get("/v1/passes/p2").status_code == 200


def test_the_same_address_with_another_accept_is_another_answer(call, looks):
    assert call.get("/v1/measurements").headers["Content-Type"] == "application/json"
    table = call.get("/v1/measurements", headers={"Accept": "text/csv"})
    assert table.headers["Content-Type"].startswith("text/csv")


def test_nobody_without_a_key_is_answered_from_memory(served, call, looks):
    call.get("/v1/passes/p1").raise_for_status()
    with served.client(None) as stranger:
        assert stranger.get("/v1/passes/p1").status_code == 401
    with served.client(served.key(Scope.READ)) as reader:
        reader.get("/v1/jobs").raise_for_status()  # the key is known from here on
        answer, looked = looks.of(lambda: reader.get("/v1/passes/p1"))
        assert answer.status_code == 200
        assert looked > 0  # callers with other scopes are not given each other's answers


def test_calls_that_come_while_the_answer_is_made_wait_for_it(served, call, looks):
    call.get("/v1/passes").raise_for_status()
    with served.store.change() as session:
        session.get(Pass, "p1").train = "ICE 2"
    looks.gate.clear()
    before = looks.count
    with ThreadPoolExecutor(8) as pool, served.client() as many:
        answers = [pool.submit(many.get, "/v1/passes") for _ in range(8)]
        while looks.count == before:
            pass
        looks.gate.set()
        found = [each.result(20.0) for each in answers]
    assert {each.json()["passes"][0]["train"] for each in found} == {"ICE 2"}
    assert looks.count - before == 1


def test_a_state_that_no_row_tells_is_told_within_moments(served, call):
    def problem():
        return call.get("/v1/station").json()["sensors"][0]["problem"]

    assert problem() is None
    served.captures["left"].broken = "the cable is out"
    with ThreadPoolExecutor(1) as pool:
        seen = pool.submit(lambda: next(found for found in iter(problem, 0) if found))
        assert seen.result(20.0) == "the cable is out"


def test_metrics_count_remembered_answers_by_their_route(call, looks):
    for _ in range(3):
        call.get("/v1/passes/p1").raise_for_status()
    line = 'station_http_requests_total{method="GET",route="/v1/passes/{pass_id}",status="200"} 4.0'
    assert line in call.get("/metrics").text


def test_what_no_mark_allows_is_never_remembered(call, looks):
    call.get("/metrics").raise_for_status()
    _, looked_again = looks.of(lambda: call.get("/metrics"))
    assert looked_again > 0


def test_postgresql_is_asked_every_time(postgres, tmp_path):
    url = postgres.empty_database()
    migrate(url)
    served = Served(tmp_path, None, store_url=url)
    try:
        with served.client() as call:
            call.put("/v1/passes/p1", json={}).raise_for_status()
            call.get("/v1/passes/p1").raise_for_status()
            _, looked = Looks(served).of(lambda: call.get("/v1/passes/p1"))
    finally:
        served.close()
    assert looked > 0


def test_a_change_of_what_an_answer_is_not_made_of_leaves_it_alone(served, call, looks):
    call.get("/v1/passes/p1").raise_for_status()
    call.get("/v1/jobs").raise_for_status()
    with served.store.change() as session:
        add_job(session, "j1", JobKind.COMPACT, "all", at=served.station.now())
    _, looked = looks.of(lambda: call.get("/v1/passes/p1"))
    jobs, looked_for_jobs = looks.of(lambda: call.get("/v1/jobs"))
    assert looked == 0
    assert looked_for_jobs > 0
    assert [each["id"] for each in jobs.json()["jobs"]] == ["j1"]


def test_a_change_by_a_hand_that_says_nothing_is_seen_too(served, call, looks):
    assert call.get("/v1/passes/p1").json()["train"] == "ICE 1"
    with sqlite3.connect(served.layout.root / "station.sqlite") as somebody:
        somebody.execute("UPDATE passes SET train = 'ICE 2'")
    somebody.close()
    assert call.get("/v1/passes/p1").json()["train"] == "ICE 2"
