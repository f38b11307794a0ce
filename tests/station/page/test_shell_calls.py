"""Shows that with a browser's login nothing changes but by the station's own pages, and that a
person is told of every refusal in words, a program by a problem document."""

import re

import pytest
from paged_station import PEOPLE
from test_shell_templates import faults_of

from station.api import CSRF_HEADER
from station.errors import StateConflict, StoreUnusable
from station.store.callers import Scope

HARMLESS = {"GET", "HEAD", "OPTIONS"}
_GAP = re.compile(r"\{[^}]+\}")


def routes_of(app):
    """Every method and address of the whole application, with something for each gap."""
    found = set()
    waiting = list(app.routes)
    while waiting:
        route = waiting.pop()
        waiting += getattr(getattr(route, "original_router", None), "routes", [])
        for method in getattr(route, "methods", None) or ():
            found.add((method, _GAP.sub("x1", route.path)))
    return sorted(found)


def unsafe_of(app):
    open_to_all = {("POST", "/login")}
    return [one for one in routes_of(app) if one[0] not in HARMLESS and one not in open_to_all]


def test_no_unsafe_call_of_the_whole_application_goes_by_the_cookie_alone(paged):
    found = unsafe_of(paged.app)
    assert {("POST", "/logout"), ("POST", "/set-up/keys"), ("PUT", "/v1/passes/x1")} <= {*found}
    with paged.browser(paged.key(*Scope)) as browser:
        del browser.headers[CSRF_HEADER]
        for method, path in found:
            for headers in ({}, {CSRF_HEADER: "0" * 64}):
                reply = browser.request(method, path, headers={"Accept": "*/*", **headers})
                assert reply.status_code == 401, (method, path)
                assert "load the station's page anew" in reply.json()["detail"]


def test_a_call_that_its_page_vouches_for_goes_through(paged):
    with paged.browser(paged.key(*Scope)) as browser:
        reply = browser.post("/v1/passes/x1/finish", json={}, headers={"Accept": "*/*"})
    assert reply.status_code == 404


def test_the_token_of_one_browser_is_none_of_another(paged):
    with (
        paged.browser(paged.key(*Scope)) as one,
        paged.browser(paged.key(*Scope)) as other,
    ):
        other.headers[CSRF_HEADER] = one.headers[CSRF_HEADER]
        assert other.post("/logout", headers={"Accept": "*/*"}).status_code == 401


def test_a_key_beside_a_cookie_is_what_counts(paged):
    with paged.browser(paged.key(*Scope)) as browser:
        headers = {"Authorization": f"Bearer {paged.key(Scope.READ)}", "Accept": "*/*"}
        assert browser.get("/set-up/keys", headers=headers).status_code == 403


def test_no_get_writes_to_the_store(paged, monkeypatch):
    written = []
    with paged.browser(paged.key(*Scope)) as browser:
        browser.get("/set-up")  # notes that the key was used
        change = type(paged.store).change

        def watched(store):
            written.append(store)
            return change(store)

        monkeypatch.setattr(type(paged.store), "change", watched)
        for method, path in routes_of(paged.app):
            if method == "GET" and not path.endswith("/events"):
                browser.get(path)
        monkeypatch.undo()
    assert written == []


def test_a_person_is_told_of_a_missing_page_with_the_way_back(paged):
    with paged.browser(paged.key(Scope.READ)) as browser:
        reply = browser.get("/nowhere/<img src=x onerror=alert(1)>")
    assert reply.status_code == 404
    assert reply.headers["content-type"] == "text/html; charset=utf-8"
    assert 'href="/now"' in reply.text
    assert "<img" not in reply.text
    assert reply.headers["X-Request-Id"] in reply.text


def test_a_person_is_told_what_a_key_may_not(paged):
    with paged.browser(paged.key(Scope.READ)) as browser:
        reply = browser.get("/set-up/keys")
    assert reply.status_code == 403
    assert "this call needs admin" in reply.text


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (StateConflict("pass p1 is recording", state="recording"), 409),
        (StoreUnusable("the store does not answer"), 503),
        (RuntimeError("secret of the inside"), 500),
    ],
)
def test_a_person_is_told_of_what_fails_within_a_program_by_a_problem(
    paged, monkeypatch, error, status
):
    def fail():
        raise error

    monkeypatch.setattr("station.page.set_up.routes.sensor_views", lambda *_: fail())
    key = paged.key(Scope.READ)
    with paged.browser(key) as browser, paged.client(Authorization=f"Bearer {key}") as program:
        told, problem = browser.get("/set-up"), program.get("/set-up")
    assert told.status_code == problem.status_code == status
    assert told.headers["content-type"].startswith("text/html")
    assert problem.headers["content-type"] == "application/problem+json"
    assert "secret" not in told.text + problem.text
    assert ("Retry-After" in told.headers) == (status == 503)


def test_a_person_is_told_of_an_address_that_cannot_be(paged):
    with paged.browser(paged.key(*Scope)) as browser:
        reply = browser.get("/set-up/audit?before=none")
    assert reply.status_code == 422
    assert "before" in reply.text


def test_a_part_of_a_page_is_answered_by_a_problem_that_its_script_can_say(paged):
    headers = {**PEOPLE, "HX-Request": "true"}
    with paged.browser(paged.key(*Scope)) as browser:
        reply = browser.post("/set-up/keys/0123abcd/revoke", headers=headers)
    assert reply.status_code == 404
    assert "no key of that id" in reply.json()["detail"]


def test_the_pages_of_refusals_hold_the_strict_policy_too(paged):
    with paged.browser(paged.key(Scope.READ)) as browser:
        for path in ("/set-up", "/nowhere", "/set-up/keys", "/login"):
            headers = browser.get(path).headers
            policy = headers["Content-Security-Policy"]
            assert "script-src 'self'; style-src 'self'" in policy
            assert "unsafe" not in policy
            assert headers["X-Content-Type-Options"] == "nosniff"
            assert headers["Cache-Control"] == "no-store"


def test_no_page_as_it_is_sent_has_anything_inline(paged):
    seen = 0
    with paged.browser(paged.key(*Scope)) as browser:
        for method, path in routes_of(paged.app):
            if method != "GET" or path.startswith("/v1/"):
                continue
            reply = browser.get(path, follow_redirects=True)
            if reply.headers["content-type"].startswith("text/html") and path != "/docs":
                seen += 1
                assert faults_of(reply.text) == [], path
                assert "unsafe" not in reply.headers["Content-Security-Policy"], path
    assert seen > 20
