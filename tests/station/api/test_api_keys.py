"""Shows what becomes of keys at the door: good, bad, expired, revoked, many bad ones, and that none
is ever written down."""

import logging
import time
from datetime import timedelta

import httpx
import pytest

from station.api.gate import Gate
from station.errors import KeyRefused
from station.operations import Keys, key_id_of
from station.store import Actor, Key
from station.store.callers import Scope

PLACE = "/v1/station"
FEW = pytest.mark.parametrize(
    "served", [{"web": {"bad_keys": 3, "bad_key_every_s": 60.0}}], indirect=True
)


def status_with(client, key, path=PLACE):
    return client.get(path, headers={"Authorization": f"Bearer {key}"}).status_code


def until_refused(client, key):
    began_s = time.monotonic()
    while (status := status_with(client, key)) == 200:
        assert time.monotonic() - began_s < 20.0
    assert status == 401


def keys_of(served):
    return Keys(served.store, Actor("test"), served.station.now())


def test_a_key_that_is_expired_or_revoked_opens_nothing_more(served):
    keys = keys_of(served)
    soon = served.station.now() + timedelta(days=1)
    good = keys.create("good", [Scope.READ], soon)
    revoked = keys.create("revoked", [Scope.READ], None)
    expired = keys.create("expired", [Scope.READ], soon)
    with served.client(None) as client:
        assert [status_with(client, key) for key in (good, revoked, expired)] == [200] * 3
        keys.revoke(key_id_of(revoked))
        with served.store.change() as session:
            session.get(Key, key_id_of(expired)).expires_at = served.station.now()
        # One refusal each: with more, this address would run out of bad keys in between.
        for key in (revoked, expired):
            until_refused(client, key)
        assert status_with(client, good) == 200


def test_a_good_key_is_recalled_for_a_second_and_then_looked_up_again(served):
    now_s = 100.0
    gate = Gate(served.station, None, clock=lambda: now_s)
    keys = keys_of(served)
    key = keys.create("controller", [Scope.OPERATE], None)
    assert gate.recall(key) is None
    assert gate.admit(key, "10.0.0.7").name == "controller"
    keys.revoke(key_id_of(key))
    now_s += 0.99
    assert gate.recall(key).name == "controller"
    now_s += 0.01
    assert gate.recall(key) is None
    with pytest.raises(KeyRefused):
        gate.admit(key, "10.0.0.7")
    now_s -= 0.5
    assert gate.recall(key) is None


def test_what_is_recalled_of_a_key_is_as_old_as_its_lookup_not_as_its_last_use(served):
    now_s = 100.0
    gate = Gate(served.station, None, clock=lambda: now_s)
    key = keys_of(served).create("controller", [Scope.OPERATE], None)
    gate.admit(key, "10.0.0.7")
    for _ in range(3):
        now_s += 0.3
        assert gate.recall(key) is not None
    now_s += 0.3
    assert gate.recall(key) is None


def test_a_rotated_key_and_its_successor_are_both_good_for_the_overlap(served):
    keys = keys_of(served)
    old = keys.create("controller", [Scope.OPERATE], None)
    new = keys.rotate(key_id_of(old), timedelta(hours=1), None)
    at_once = keys.rotate(key_id_of(new), timedelta(0), None)
    with served.client(None) as client:
        assert [status_with(client, key) for key in (old, new, at_once)] == [200, 401, 200]


def test_the_use_of_a_key_is_noted_but_not_with_every_call(served):
    key = keys_of(served).create("planner", [Scope.READ], None)

    def noted():
        with served.store.look() as session:
            return session.get(Key, key_id_of(key)).last_used_at

    assert noted() is None
    with served.client(key) as client:
        client.get(PLACE)
        first = noted()
        client.get(PLACE)
    assert first is not None
    assert noted() == first


@FEW
def test_many_bad_keys_are_429_with_when_to_come_again(served):
    with served.client(None) as client:
        assert [status_with(client, f"bad-{n}") for n in range(5)] == [401, 401, 401, 429, 429]
        reply = client.get(PLACE, headers={"Authorization": "Bearer bad"})
    assert 0 < int(reply.headers["Retry-After"]) <= 60
    assert reply.json()["title"] == "Too many bad keys"


@FEW
def test_a_good_key_is_not_slowed_by_bad_ones_from_elsewhere_nor_one_in_use_by_its_neighbours(
    served,
):
    keys = keys_of(served)
    used, fresh = (keys.create(name, [Scope.READ], None) for name in ("used", "fresh"))
    elsewhere = httpx.HTTPTransport(local_address="127.0.0.9")
    with served.client(None) as client:
        assert status_with(client, used) == 200
        assert [status_with(client, "bad") for _ in range(4)][-1] == 429
        assert status_with(client, used) == 200
        assert status_with(client, fresh) == 429
    with httpx.Client(base_url=served.url, transport=elsewhere) as client:
        assert status_with(client, fresh) == 200


@FEW
def test_a_call_without_any_key_costs_no_allowance(served):
    with served.client(None) as client:
        assert {client.get(PLACE).status_code for _ in range(10)} == {401}
        assert status_with(client, keys_of(served).create("a", [Scope.READ], None)) == 200


@FEW
def test_who_is_no_proxy_of_the_settings_is_not_believed_who_is_calling(served):
    with served.client(None) as client:
        statuses = [
            client.get(
                PLACE,
                headers={"Authorization": "Bearer bad", "X-Forwarded-For": f"10.0.0.{n}"},
            ).status_code
            for n in range(5)
        ]
    assert statuses[-1] == 429


@pytest.mark.parametrize(
    "served", [{"web": {"bad_keys": 3, "proxies": ["127.0.0.1"]}}], indirect=True
)
def test_a_proxy_of_the_settings_is_believed(served):
    with served.client(None) as client:
        for caller, status in (("10.0.0.1", 429), ("10.0.0.2", 401)):
            headers = {"Authorization": "Bearer bad", "X-Forwarded-For": caller}
            times = 4 if status == 429 else 1
            found = [client.get(PLACE, headers=headers).status_code for _ in range(times)]
            assert found[-1] == status


def test_a_browser_is_asked_for_the_key_of_the_docs_and_of_nothing_else(served, call):
    key = keys_of(served).create("reader", [Scope.READ], None)
    with served.client(None) as client:
        assert "Basic" in client.get("/docs").headers["WWW-Authenticate"]
        assert "Basic" not in client.get(PLACE).headers["WWW-Authenticate"]
        for name in ("", "anybody"):
            assert client.get("/docs", auth=(name, key)).status_code == 200
            assert client.get("/openapi.json", auth=(name, key)).status_code == 200
        assert client.get("/docs", auth=("anybody", "no key")).status_code == 401
        assert client.get("/docs", auth=("anybody", "\x00")).status_code == 401
        # A page of somebody else could have the browser send it along.
        assert client.get(PLACE, auth=("anybody", key)).status_code == 401
        assert client.put("/v1/passes/p1", json={}, auth=("a", key)).status_code == 401


def test_two_keys_at_once_are_none(served):
    key = keys_of(served).create("reader", [Scope.READ], None)
    with served.client(None) as client:
        headers = [("Authorization", f"Bearer {key}"), ("Authorization", "Bearer other")]
        assert client.get(PLACE, headers=headers).status_code == 401


def test_no_key_is_ever_written_into_the_log(served, capfd):
    key = keys_of(served).create("reader", [Scope.READ], None)
    logging.getLogger("uvicorn.error").setLevel(logging.INFO)
    with served.client(None) as client:
        status_with(client, key)
        status_with(client, key, "/nowhere")
        status_with(client, f"{key}x")
        client.get("/docs", auth=("anybody", key))
        client.get(PLACE, params={"key": key})
        client.put("/v1/passes/p1", content=key, headers={"Authorization": f"Bearer {key}"})
        client.get(PLACE, headers={"Authorization": f"Basic {key}", "Cookie": key})
    logged = capfd.readouterr().err
    assert '"event": "answered"' in logged
    assert key not in logged
    assert key.split("_")[2] not in logged
