"""Shows who sees and does what on the set-up, and that no secret is on any page."""

import re
import threading
import time

import pytest
from paged_station import ENVIRONMENT_KEY, PASSWORD
from test_shell_calls import routes_of

from station.doctor import Checkup, Finding
from station.operations import DataLayout, key_id_of, utc_now
from station.settings import load_settings
from station.store import (
    Action,
    Actor,
    AuditEntry,
    Key,
    Login,
    Pass,
    PassState,
    Recalibration,
    audit,
)
from station.store.callers import Scope

PARTS = {
    "sensors": "",
    "limits": "/limits",
    "nightly": "/nightly",
    "storage": "/storage",
    "host": "/host",
}
HIDDEN = ("/keys", "/keys/list", "/logins", "/audit")
MARKUP = "<img src=x onerror=alert(1)>"
_TEXT = re.compile(r'value="(tl_[0-9a-f]{8}_[A-Za-z0-9_-]{43})"')


@pytest.mark.parametrize("scope", Scope)
def test_everybody_sees_what_is_no_secret_and_administrators_the_rest(paged, scope):
    with paged.browser(paged.key(scope)) as browser:
        for path in PARTS.values():
            page = browser.get(f"/set-up{path}")
            assert page.status_code == 200
            assert ('href="/set-up/keys"' in page.text) == (scope is Scope.ADMIN)
        for path in HIDDEN:
            assert browser.get(f"/set-up{path}").status_code == (
                200 if scope is Scope.ADMIN else 403
            )


@pytest.mark.parametrize("scope", Scope)
def test_a_button_is_there_for_who_may_press_it_and_refused_to_others(paged, scope):
    buttons = {
        "/set-up/nightly": ("/set-up/nightly/order", Scope.CALIBRATE),
        "/set-up/host": ("/set-up/host/examine", Scope.ADMIN),
    }
    with paged.browser(paged.key(scope)) as browser:
        for page, (address, needed) in buttons.items():
            may = scope in {needed, Scope.ADMIN}
            assert (f'hx-post="{address}"' in browser.get(page).text) == may
            if not may:
                assert browser.post(address, data={"sensor": "left"}).status_code == 403
        for address in (
            "/keys",
            "/keys/0123abcd/rotate",
            "/keys/0123abcd/revoke",
            "/logins/0123456789abcdef/end",
        ):
            refused = browser.post(f"/set-up{address}", data={"name": "x", "keep_h": 1})
            assert (refused.status_code == 403) == (scope is not Scope.ADMIN)


def made(reply):
    assert reply.status_code == 201, reply.text
    return _TEXT.search(reply.text)[1]


def test_a_key_is_made_shown_once_replaced_and_revoked(paged):
    with paged.browser(paged.key(Scope.ADMIN, name="chief")) as browser:
        asked = {"name": "tablet 7", "scopes": ["read", "operate"], "days": "30"}
        first = made(browser.post("/set-up/keys", data=asked))
        listed = browser.get("/set-up/keys/list").text
        assert "tablet 7" in listed
        assert first.split("_", 2)[2] not in listed
        second = made(browser.post(f"/set-up/keys/{key_id_of(first)}/rotate", data={"keep_h": "0"}))
        reply = browser.post(f"/set-up/keys/{key_id_of(second)}/revoke")
        assert (reply.status_code, "keys" in reply.headers["HX-Trigger"]) == (204, True)
    with paged.store.look() as session:
        old, new = (session.get(Key, key_id_of(text)) for text in (first, second))
        assert old.scopes == new.scopes == {"scopes": ["operate", "read"]}
        assert old.expires_at <= utc_now()
        assert new.revoked_at is not None
        asked = session.query(AuditEntry).filter_by(who="chief", kind="key")
        assert [entry.action for entry in asked.order_by(AuditEntry.id)] == ["add", "add", "revoke"]


@pytest.mark.parametrize(
    ("asked", "status", "says"),
    [
        ({"name": MARKUP, "scopes": ["read"]}, 422, "letters, digits"),
        ({"name": "nobody"}, 422, "without a scope"),
        ({"name": "nobody", "scopes": ["root"]}, 422, "scopes"),
        ({"name": "nobody", "scopes": ["read"], "days": "-1"}, 422, "days"),
        ({"name": "nobody", "scopes": ["read"], "days": "nan"}, 422, "days"),
    ],
)
def test_a_key_that_cannot_be_is_refused_in_words(paged, asked, status, says):
    with paged.browser(paged.key(Scope.ADMIN)) as browser:
        reply = browser.post("/set-up/keys", data=asked, headers={"Accept": "*/*"})
    assert reply.status_code == status
    assert says in reply.json()["detail"]


def test_the_answer_with_a_new_key_is_kept_nowhere(paged):
    with paged.browser(paged.key(Scope.ADMIN)) as browser:
        asked = {"name": "kept nowhere", "scopes": ["read"]}
        again = {"Idempotency-Key": "k1"}
        text = made(browser.post("/set-up/keys", data=asked, headers=again))
        assert browser.post("/set-up/keys", data=asked, headers=again).status_code == 409
    database = (paged.settings.data_dir / "station.sqlite").read_bytes()
    log = paged.settings.data_dir / "station.sqlite-wal"
    kept = database + (log.read_bytes() if log.exists() else b"")
    assert text.split("_", 2)[2].encode() not in kept


def test_a_browser_is_logged_out_by_somebody_else_at_once(paged):
    with paged.browser(paged.key(Scope.READ, name="lost tablet")) as lost:
        with paged.browser(paged.key(Scope.ADMIN)) as browser:
            page = browser.get("/set-up/logins").text
            assert page.count("this browser") == 1
            row = page[page.index("lost tablet") :]
            address = re.search(r'hx-post="([^"]+)"', row)[1]
            assert lost.get("/set-up").status_code == 200
            assert browser.post(address).status_code == 204
            assert browser.post(address).status_code == 404
        assert lost.get("/set-up").status_code == 303


def test_a_recalibration_is_ordered_by_whom_it_says(paged):
    with paged.browser(paged.key(Scope.CALIBRATE, name="metrologist")) as browser:
        assert browser.post("/set-up/nightly/order", data={"sensor": "left"}).status_code == 204
        again = browser.post(
            "/set-up/nightly/order", data={"sensor": "left"}, headers={"Accept": "*/*"}
        )
        assert "is being recalibrated" in again.json()["detail"]
        assert "metrologist" in browser.get("/set-up/nightly/nights").text
    with paged.store.look() as session:
        row = session.query(Recalibration).filter_by(sensor="left").one()
        assert (row.ordered_by, paged.queue.submitted) == (
            "metrologist",
            [("recalibrate", row.job_id)],
        )


def test_a_sensor_that_is_away_is_told_and_the_page_comes_at_once(paged):
    paged.captures["right"].camera = None
    paged.captures["left"].camera = {
        "vendor": MARKUP,
        "model": "M",
        "serial": "1",
        "exposure_us": "900.0",
    }
    try:
        with paged.browser(paged.key(Scope.READ)) as browser:
            time.sleep(1.0)  # the look before is good for a second
            began_s = time.monotonic()
            page = browser.get("/set-up").text
            assert time.monotonic() - began_s < 60.0
        assert "Not reached" in page
        assert "1 differ" in page
        assert MARKUP not in page
        assert "&lt;img src=x" in page
    finally:
        for capture in paged.captures.values():
            capture.camera = {}


def test_the_trail_is_searched_and_read_page_by_page_as_text(paged):
    with paged.store.change() as session:
        for number in range(60):
            subject = MARKUP if number == 0 else "flood"
            audit(
                session,
                Action.CANCEL,
                "job",
                subject,
                by=Actor(MARKUP),
                at=utc_now(),
                after={"why": MARKUP},
            )
    with paged.browser(paged.key(Scope.ADMIN)) as browser:
        first = browser.get("/set-up/audit", params={"who": MARKUP}).text
        older = re.search(r'href="(/set-up/audit\?[^"]*before=\d+)"', first)[1]
        rest = browser.get(older.replace("&amp;", "&")).text
        none = browser.get("/set-up/audit", params={"subject": "nobody"}).text
    assert (first.count("<tr>"), rest.count("<tr>")) == (51, 11)
    assert MARKUP not in first + rest
    assert "No entry." in none


def test_the_host_is_not_examined_while_a_train_passes(paged):
    with paged.store.change() as session:
        session.add(Pass(id="p9", state=PassState.RECORDING, opened_at=utc_now()))
    try:
        with paged.browser(paged.key(Scope.ADMIN)) as browser:
            reply = browser.post("/set-up/host/examine", headers={"Accept": "*/*"})
        assert reply.status_code == 409
        assert "pass p9 is recording" in reply.json()["detail"]
    finally:
        with paged.store.change() as session:
            session.get(Pass, "p9").state = PassState.FAILED


def test_findings_come_while_other_pages_go_on(paged):
    go_on = threading.Event()
    found = [Finding("clock", MARKUP, "apt-get install chrony"), Finding("memory", "enough")]
    paged.app.state.checkup = Checkup(lambda: found * go_on.wait(30.0), utc_now)
    with paged.browser(paged.key(Scope.ADMIN)) as browser:
        assert "has not been examined" in browser.get("/set-up/host").text
        assert browser.post("/set-up/host/examine").status_code == 204
        assert "being examined" in browser.get("/set-up/host/findings").text
        assert browser.get("/set-up/limits").status_code == 200
        go_on.set()
        until_s = time.monotonic() + 30.0
        while "apt-get" not in (page := browser.get("/set-up/host/findings").text):
            assert time.monotonic() < until_s
            time.sleep(0.02)
    assert MARKUP not in page
    assert page.index("clock") < page.index("memory")


SECRET_SETTINGS = pytest.mark.parametrize(
    "paged",
    [{"web": {"login_h": 1.0}, "recalibration": {"at": "02:30:00", "zone": "Europe/Berlin"}}],
    indirect=True,
)


@SECRET_SETTINGS
def test_no_key_hash_password_or_address_of_the_database_is_on_any_page(paged, monkeypatch):
    url = f"postgresql://treadline:{PASSWORD}@127.47.3.1/treadline"
    key = paged.key(Scope.ADMIN)
    with paged.browser(key) as browser:
        # What the pages know of the store's address is this; the store itself stays the same.
        monkeypatch.setattr(type(paged.station.layout), "store_url", property(lambda _: url))
        monkeypatch.setattr("station.page.set_up.host_views.revision_of", lambda _: "0015")
        cookies = list(browser.cookies.values())
        pages = [
            browser.get(path).content
            for method, path in routes_of(paged.app)
            if method == "GET" and not path.endswith("/events")
        ]
        monkeypatch.undo()
    with paged.store.look() as session:
        hashes = [
            *(row.secret_sha256 for row in session.query(Key)),
            *(row.sha256 for row in session.query(Login)),
        ]
    secrets = [PASSWORD, url, ENVIRONMENT_KEY, key, key.split("_", 2)[2], *cookies, *hashes]
    assert len(pages) > 40
    for page in pages:
        assert [secret for secret in secrets if secret.encode() in page] == []


def test_the_settings_know_their_file_and_the_page_names_it(paged, tmp_path, monkeypatch):
    file = tmp_path / "station.toml"
    file.write_text('data_dir = "d"\n[[sensors]]\nid = "left"\naddress = "127.47.1.1"\n')
    settings = load_settings(file)
    assert settings.file == file
    assert paged.settings.file is None
    assert DataLayout.of(settings).root == tmp_path / "d"
    with paged.browser(paged.key(Scope.READ)) as browser:
        assert "not started from a settings file" in browser.get("/set-up/host").text
        monkeypatch.setattr(type(paged.settings), "file", property(lambda _: file))
        assert str(file) in browser.get("/set-up/host").text
