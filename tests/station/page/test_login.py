"""Shows how a browser comes in by a key, what its cookie is, and when it is worth nothing more.
What the store keeps of it, and calls with it, are shown there and below `test_login_calls`."""

import re
import time
from contextlib import ExitStack
from datetime import timedelta

import pytest
from paged_station import ENVIRONMENT_KEY, PEOPLE, log_in, token_of

from station.operations import key_id_of, utc_now
from station.store import AuditEntry, Key, Login
from station.store.callers import Scope

PATIENCE_S = 30.0
BEHIND_A_PROXY = pytest.mark.parametrize(
    "paged", [{"web": {"proxies": ["127.0.0.1"]}}], indirect=True
)
FEW = pytest.mark.parametrize(
    "paged", [{"web": {"bad_keys": 2, "bad_key_every_s": 60.0}}], indirect=True
)


def cookie_of(reply):
    """The name and the attributes of the one cookie that an answer sets."""
    (header,) = reply.headers.get_list("set-cookie")
    first, *attributes = re.split(r"; *", header)
    return first.partition("=")[0], {each.lower() for each in attributes}


def has_ended(browser, path="/set-up"):
    """Wait until a browser is sent to the login; what is recalled is so for a second."""
    until_s = time.monotonic() + PATIENCE_S
    while browser.get(path).status_code != 303:
        assert time.monotonic() < until_s, "the login did not end"
        time.sleep(0.05)
    return True


def test_a_good_key_is_changed_for_a_cookie_that_no_script_and_no_other_page_gets(paged):
    with paged.browser() as browser:
        reply = log_in(browser, paged.key(Scope.READ))
        assert (reply.status_code, reply.headers["Location"]) == (303, "/now")
        name, attributes = cookie_of(reply)
        assert name == "treadline"
        assert attributes == {"httponly", "samesite=lax", "path=/", "max-age=43200"}
        assert browser.get("/set-up").status_code == 200


@BEHIND_A_PROXY
def test_an_encrypted_cookie_is_sent_back_encrypted_alone_and_to_this_host_alone(paged):
    encrypted = {"X-Forwarded-Proto": "https"}
    with paged.browser() as browser:
        browser.headers.update(encrypted)
        reply = log_in(browser, paged.key(Scope.READ))
        name, attributes = cookie_of(reply)
        assert name == "__Host-treadline"
        assert {"secure", "httponly", "samesite=lax", "path=/"} < attributes
        assert not any(each.startswith("domain") for each in attributes)
        cookie = reply.headers["set-cookie"].partition(";")[0]
        del browser.headers["X-Forwarded-Proto"]
        browser.cookies.clear()
        plain = browser.get("/set-up", headers={"Cookie": cookie})
        assert plain.status_code == 303, "a cookie for encrypted calls is none for plain ones"
        assert browser.get("/set-up", headers={"Cookie": cookie, **encrypted}).status_code == 200


@BEHIND_A_PROXY
def test_logging_out_takes_the_encrypted_cookie_back(paged):
    with paged.browser() as browser:
        browser.headers["X-Forwarded-Proto"] = "https"
        cookie = log_in(browser, paged.key(Scope.READ)).headers["set-cookie"].partition(";")[0]
        browser.cookies.clear()
        browser.headers["Cookie"] = cookie
        reply = browser.post("/logout", headers={"X-CSRF-Token": token_of(browser)})
        name, attributes = cookie_of(reply)
        assert name == "__Host-treadline"
        assert {"max-age=0", "secure", "httponly", "path=/"} <= attributes
        assert has_ended(browser)


def test_each_login_is_another_cookie_and_ends_the_one_before(paged):
    key = paged.key(Scope.READ)
    with paged.browser() as browser, paged.browser() as thief:
        browser.cookies.set("treadline", "put-there-by-somebody-else", "127.0.0.1")
        log_in(browser, key)
        first = browser.cookies["treadline"]
        assert first != "put-there-by-somebody-else"
        thief.cookies.set("treadline", first)
        assert thief.get("/set-up").status_code == 200
        log_in(browser, key)
        assert browser.cookies["treadline"] != first
        assert has_ended(thief)


def test_a_bad_key_is_told_on_the_page_and_nothing_of_it_comes_back(paged):
    with paged.browser() as browser:
        reply = log_in(browser, "tl_0123abcd_<img src=x onerror=alert(1)>")
    assert reply.status_code == 401
    assert "does not accept this key" in reply.text
    assert "0123abcd" not in reply.text
    assert "onerror" not in reply.text
    assert "set-cookie" not in reply.headers


@FEW
def test_who_tries_many_keys_is_told_when_to_come_again(paged):
    with paged.browser() as browser:
        replies = [log_in(browser, f"bad-{n}") for n in range(3)]
        assert [reply.status_code for reply in replies] == [401, 401, 429]
        assert 0 < int(replies[-1].headers["Retry-After"]) <= 60
        assert "too many bad keys" in replies[-1].text


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "http://elsewhere.example"},
        {"Origin": "null"},
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
    ],
)
def test_the_page_of_somebody_else_logs_nobody_in(paged, headers):
    key = paged.key(Scope.READ)
    with paged.browser() as browser:
        reply = browser.post("/login", data={"key": key}, headers=headers)
    assert reply.status_code == 401
    assert "set-cookie" not in reply.headers
    assert reply.headers["content-type"].startswith("text/html")


def test_a_proxy_that_knows_the_host_by_another_name_is_no_page_of_somebody_else(paged):
    headers = {"Origin": "https://station.example", "Sec-Fetch-Site": "same-origin"}
    with paged.browser() as browser:
        reply = browser.post("/login", data={"key": paged.key(Scope.READ)}, headers=headers)
    assert reply.status_code == 303


@pytest.mark.parametrize(
    ("wanted", "gone_to"),
    [
        ("/passes?train=7", "/passes?train=7"),
        ("//elsewhere.example/", "/now"),
        ("/\\elsewhere.example", "/now"),
        ("https://elsewhere.example/", "/now"),
        ("javascript:alert(1)", "/now"),
        ("/\t/elsewhere.example", "/now"),
        ("", "/now"),
    ],
)
def test_the_login_leads_to_the_station_alone(paged, wanted, gone_to):
    with paged.browser() as browser:
        data = {"key": paged.key(Scope.READ), "leads_to": wanted}
        assert browser.post("/login", data=data).headers["Location"] == gone_to


def test_who_goes_to_a_page_is_led_to_the_login_and_back(paged):
    with paged.browser() as browser:
        reply = browser.get("/set-up/audit?who=plc%20%3Cb%3E")
        assert reply.status_code == 303
        form = browser.get(reply.headers["Location"])
        assert 'value="/set-up/audit?who=plc%20%3Cb%3E"' in form.text


@pytest.mark.parametrize("body", [{}, {"key": ""}, {"key": "x" * 600}])
def test_a_form_that_is_none_is_told_to_a_person_in_words(paged, body):
    with paged.browser() as browser:
        reply = browser.post("/login", data=body)
    assert reply.status_code in {401, 422}
    assert reply.headers["content-type"].startswith("text/html")
    assert "xxx" not in reply.text


def test_a_login_ends_with_its_key_revoked_expired_or_replaced_and_with_the_shift(paged):
    ends = {
        "revoked": lambda key_id: paged.keys.revoke(key_id),
        "replaced": lambda key_id: paged.keys.rotate(key_id, timedelta(0), None),
        "expired": lambda key_id: over(paged, key_id, shift=False),
        "shift over": lambda key_id: over(paged, key_id, shift=True),
    }
    with ExitStack() as stack:
        keys = {end: paged.key(Scope.READ) for end in ends}
        browsers = {end: stack.enter_context(paged.browser(key)) for end, key in keys.items()}
        for end, browser in browsers.items():
            assert browser.get("/set-up").status_code == 200
            ends[end](key_id_of(keys[end]))
        # All are recalled for the same second.
        assert [end for end, browser in browsers.items() if not has_ended(browser)] == []


def over(paged, key_id, *, shift):
    with paged.store.change() as session:
        login = session.query(Login).filter_by(key_id=key_id).one()
        (login if shift else session.get(Key, key_id)).expires_at = utc_now()


def test_a_cookie_that_was_logged_out_opens_nothing_at_once(paged):
    with paged.browser(paged.key(Scope.READ)) as browser, paged.browser() as thief:
        thief.cookies.update(dict(browser.cookies))
        browser.post("/logout")
        assert thief.get("/set-up").status_code == 303


def test_a_login_by_the_key_of_the_environment_ends_when_that_is_changed(paged):
    with paged.browser(ENVIRONMENT_KEY) as browser:
        cookies = dict(browser.cookies)
    for key, status in {
        None: 303,
        "another-key-of-32-letters-or-more": 303,
        ENVIRONMENT_KEY: 200,
    }.items():
        paged.end()
        paged.begin(key)
        with paged.browser() as browser:
            browser.cookies.update(cookies)
            assert browser.get("/set-up").status_code == status, key


def test_who_came_and_went_is_in_the_audit_trail(paged):
    with paged.browser(paged.key(Scope.READ, name="tablet 1")) as browser:
        browser.post("/logout")
    with paged.store.look() as session:
        asked = session.query(AuditEntry).filter_by(kind="login", who="tablet 1")
        found = asked.order_by(AuditEntry.id).all()
        told = [(entry.action, entry.who, entry.address) for entry in found]
    assert told == [("add", "tablet 1", "127.0.0.1"), ("revoke", "tablet 1", "127.0.0.1")]


def test_a_tab_that_is_still_open_goes_to_the_login_as_a_whole(paged):
    with paged.browser() as browser:
        page = f"{paged.url}/set-up/keys?x=1"
        headers = {"HX-Request": "true", "HX-Current-URL": page, "Accept": "*/*"}
        reply = browser.get("/set-up/keys/list", headers=headers)
    assert reply.status_code == 401
    assert reply.headers["HX-Redirect"] == "/login?next=/set-up/keys"


def test_the_login_itself_needs_no_key_and_shows_no_way_into_the_station(paged):
    with paged.client(**PEOPLE) as stranger:
        page = stranger.get("/login").text
    assert "/set-up" not in page
    assert 'name="csrf-token" content=""' in page
