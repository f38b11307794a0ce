"""Shows that a POST with an Idempotency-Key is done once however often it comes.  What is left by
one during which the API process is killed is shown by `test_api_killed_posts`."""

import threading
from datetime import timedelta

import pytest
from served_station import Served
from test_api_calibration import SESSION, record_session

from station.errors import StoreUnusable
from station.store import Calibration, KeptAnswer
from station.store.callers import Scope

ORDER = {"sensor": "left", "session": "s1"}
PLACE = "/v1/calibrations"
RIG_SENSORS = ({"id": "inner", "address": "127.0.0.2"}, {"id": "outer", "address": "127.0.0.3"})


@pytest.fixture
def rig_call(tmp_path, empty_store):
    rig = {"id": "wheel", "sensors": [each["id"] for each in RIG_SENSORS]}
    served = Served(tmp_path, empty_store, sensors=RIG_SENSORS, rigs=[rig])
    with served.client() as client:
        yield served, client
    served.close()


def order(client, key, body=ORDER, place=PLACE):
    return client.post(place, json=body, headers={"Idempotency-Key": key})


def count(served, table):
    with served.store.look() as session:
        return session.query(table).count()


def test_the_same_call_again_gets_the_same_answer_and_orders_nothing_more(served, call):
    record_session(call)
    first, again, quoted = order(call, "k1"), order(call, "k1"), order(call, '"k1"')
    assert first.status_code == 202
    for reply in (again, quoted):
        assert (reply.status_code, reply.json()) == (202, first.json())
        assert reply.headers["Location"] == first.headers["Location"]
        assert reply.headers["Retry-After"] == first.headers["Retry-After"]
        assert reply.headers["Idempotency-Replayed"] == "true"
        assert reply.headers["X-Content-Type-Options"] == "nosniff"
    assert "Idempotency-Replayed" not in first.headers
    assert count(served, Calibration) == 1
    assert len(served.queue.submitted) == 1
    assert order(call, "k2").json()["id"] != first.json()["id"]


def test_the_same_key_with_another_call_is_422(served, call):
    record_session(call)
    order(call, "k1")
    for reply in (
        order(call, "k1", {**ORDER, "method": "preplanar"}),
        order(call, "k1", {}, f"{SESSION}/finish"),
        call.post(f"{PLACE}?x=1", json=ORDER, headers={"Idempotency-Key": "k1"}),
    ):
        assert reply.status_code == 422
        assert "another call" in reply.json()["detail"]
    assert count(served, Calibration) == 1


def test_a_call_that_is_being_answered_is_409(served, call):
    record_session(call)
    call.put("/v1/passes/p1", json={})
    served.captures["left"].gate = threading.Event()
    replies = []

    def finish():
        with served.client() as client:
            replies.append(order(client, "k1", {"axles": 4}, "/v1/passes/p1/finish"))

    first = threading.Thread(target=finish)
    first.start()
    while count(served, KeptAnswer) == 0:
        assert first.is_alive()
    reply = order(call, "k1", {"axles": 4}, "/v1/passes/p1/finish")
    assert reply.status_code == 409
    assert int(reply.headers["Retry-After"]) >= 1
    served.captures["left"].gate.set()
    first.join()
    served.captures["left"].gate = None
    again = order(call, "k1", {"axles": 4}, "/v1/passes/p1/finish")
    assert (again.status_code, again.json()) == (200, replies[0].json())


def test_a_refusal_is_not_kept_and_the_call_may_come_again_when_it_is_allowed(served, call):
    call.put(SESSION, json={"sensor": "left", "target": "dots:7x8:12"})
    assert order(call, "k1").status_code == 409
    call.post(f"{SESSION}/capture")
    call.post(f"{SESSION}/finish")
    assert order(call, "k1").status_code == 202


def test_keys_of_two_callers_are_two_keys(served, call):
    record_session(call)
    first = order(call, "k1").json()["id"]
    with served.client(served.key(Scope.CALIBRATE)) as other:
        assert order(other, "k1").json()["id"] != first


def test_an_answer_is_forgotten_after_a_day(served, call):
    record_session(call)
    first = order(call, "k1").json()["id"]
    with served.store.change() as session:
        session.query(KeptAnswer).one().asked_at -= timedelta(hours=25)
    assert order(call, "k1").json()["id"] != first


def test_a_call_that_was_done_and_not_answered_finds_what_it_did(served, call):
    record_session(call)
    first = order(call, "k1").json()
    with served.store.change() as session:
        session.query(KeptAnswer).one().status = None
    assert order(call, "k1", {**ORDER, "method": "preplanar"}).status_code == 422
    again = order(call, "k1")
    assert (again.status_code, again.json()) == (202, first)
    assert "Idempotency-Replayed" not in again.headers
    assert count(served, Calibration) == 1


def test_an_answer_that_cannot_be_kept_is_503_and_the_call_finds_what_it_did(
    served, call, monkeypatch
):
    record_session(call)

    def full(*_, **__):
        raise StoreUnusable("the store cannot be used now; try again")

    with monkeypatch.context() as patch:
        patch.setattr("station.api.idempotency.keep_answer", full)
        reply = order(call, "k1")
    assert (reply.status_code, "Retry-After" in reply.headers) == (503, True)
    assert order(call, "k1").status_code == 202
    assert count(served, Calibration) == 1


def test_a_picture_that_failed_on_one_sensor_of_a_rig_is_made_whole_by_the_same_call(rig_call):
    served, call = rig_call
    call.put(SESSION, json={"rig": "wheel", "target": "dots:7x8:12"})
    left, right = served.captures.values()
    right.broken_trigger = True
    place = f"{SESSION}/capture"
    assert order(call, "k1", {}, place).status_code == 503
    right.broken_trigger = False
    assert order(call, "k1", {}, place).json()["pictures"] == 1
    assert (left.pictures, right.pictures) == (1, 1)
    assert order(call, "k2", {}, place).json()["pictures"] == 2
    assert (left.pictures, right.pictures) == (2, 2)


@pytest.mark.parametrize("key", ["", "a b", "x" * 256, "é".encode()])
def test_a_key_in_no_form_is_refused_and_nothing_is_done(served, call, key):
    record_session(call)
    reply = call.post(PLACE, json=ORDER, headers={b"Idempotency-Key": key})
    assert reply.status_code == 422
    assert count(served, Calibration) == 0


def test_without_a_key_every_call_is_a_new_one(served, call):
    record_session(call)
    assert call.post(PLACE, json=ORDER).json()["id"] != call.post(PLACE, json=ORDER).json()["id"]
