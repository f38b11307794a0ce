"""Shows that the API takes a browser's login as it takes the key that was changed for it, and
nothing more.  How browsers log in is shown with the pages."""

import logging

import pytest

from station.api import CSRF_HEADER, LoggedIn
from station.api.gate import Gate
from station.errors import KeyRefused
from station.operations import Keys, key_id_of
from station.store import Actor
from station.store.callers import Scope

PLACE = "/v1/station"


def logged_in(served, *scopes):
    """A browser's cookie, and the key that it was changed for."""
    key = served.key(*scopes)
    return served.app.state.parts.logins.begin(key, "10.0.0.7"), key


def cookie_alone(login):
    return {"Cookie": f"treadline={login.cookie}"}


def vouched(login):
    return {**cookie_alone(login), CSRF_HEADER: login.csrf_token}


def test_a_login_opens_what_its_key_opens(served):
    reader, _ = logged_in(served, Scope.READ)
    with served.client(None) as client:
        assert client.get(PLACE, headers=cookie_alone(reader)).status_code == 200
        assert client.get("/v1/audit", headers=cookie_alone(reader)).status_code == 403
        put = client.put("/v1/passes/p1", json={}, headers=vouched(reader))
        assert put.status_code == 403
    operator, _ = logged_in(served, Scope.OPERATE)
    with served.client(None) as client:
        assert client.put("/v1/passes/p1", json={}, headers=vouched(operator)).status_code == 201
        entry = client.get("/v1/passes/p1", headers=cookie_alone(operator))
    assert entry.json()["state"] == "recording"


@pytest.mark.parametrize("method", ["PUT", "POST", "PATCH", "DELETE", "PROPFIND", "put"])
def test_whatever_is_no_reading_needs_the_token_whether_there_is_such_a_call_or_not(served, method):
    login, _ = logged_in(served, Scope.ADMIN)
    with served.client(None) as client:
        for path in ("/v1/passes/p1", "/nowhere", "/docs"):
            reply = client.request(method, path, json={}, headers=cookie_alone(login))
            assert reply.status_code == 401
            assert CSRF_HEADER in reply.json()["detail"]


@pytest.mark.parametrize(
    "cookie", ["", "x", "treadline=", "treadline=nobody", "__Host-treadline={}", "other={}"]
)
def test_a_cookie_that_is_none_opens_nothing(served, cookie):
    login, _ = logged_in(served, Scope.ADMIN)
    with served.client(None) as client:
        reply = client.get(PLACE, headers={"Cookie": cookie.format(login.cookie)})
    assert reply.status_code == 401


def test_neither_a_cookie_nor_its_token_is_a_key(served):
    login, _ = logged_in(served, Scope.ADMIN)
    with served.client(None) as client:
        for text in (login.cookie, login.csrf_token, login.sha256, login.name):
            headers = {"Authorization": f"Bearer {text}"}
            assert client.get(PLACE, headers=headers).status_code == 401
        for text in (login.csrf_token, login.sha256, login.name):
            headers = {"Cookie": f"treadline={text}"}
            assert client.get(PLACE, headers=headers).status_code == 401


def test_a_bad_key_beside_a_good_cookie_is_a_bad_key(served):
    login, _ = logged_in(served, Scope.ADMIN)
    with served.client("no-key") as client:
        assert client.get(PLACE, headers=cookie_alone(login)).status_code == 401


def test_logins_that_are_over_cost_no_allowance_of_bad_keys(served):
    with served.client(None) as client:
        gone = {"Cookie": "treadline=over"}
        assert {client.get(PLACE, headers=gone).status_code for _ in range(30)} == {401}
    with served.client(served.key(Scope.READ)) as client:
        assert client.get(PLACE).status_code == 200


def test_a_login_is_recalled_for_a_second_and_then_looked_up_again(served):
    now_s = 100.0
    gate = Gate(served.station, None, clock=lambda: now_s)
    login, key = logged_in(served, Scope.READ)
    assert gate.recall(login.cookie) is None
    assert gate.admit_login(login.cookie).name == "test"
    Keys(served.store, Actor("test"), served.station.now()).revoke(key_id_of(key))
    now_s += 0.99
    assert gate.recall(login.cookie) is not None
    now_s += 0.01
    assert gate.recall(login.cookie) is None
    with pytest.raises(KeyRefused, match="log in again"):
        gate.admit_login(login.cookie)


def test_neither_cookie_nor_token_is_ever_written_into_the_log(served, capfd):
    logging.getLogger("uvicorn.error").setLevel(logging.INFO)
    login, _ = logged_in(served, Scope.ADMIN)
    with served.client(None) as client:
        client.get(PLACE, headers=vouched(login))
        client.get("/nowhere", headers=vouched(login))
        client.post("/v1/passes/p1/finish", json={}, headers=vouched(login))
        client.put("/v1/passes/p1", json={}, headers=cookie_alone(login))
    logged = capfd.readouterr().err
    assert '"event": "answered"' in logged
    for secret in (login.cookie, login.csrf_token, login.sha256):
        assert secret not in logged


def test_what_a_login_is_printed_as_does_not_hold_its_cookie():
    login = LoggedIn("a-cookie-nobody-may-see")
    assert "nobody-may-see" not in repr(login)
