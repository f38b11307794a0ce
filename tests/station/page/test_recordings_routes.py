"""Shows what the addresses of the recordings page answer, to whom, and that nothing written by
somebody becomes markup; what scripts make of it the walks show."""

from datetime import UTC, datetime

import pytest
from demo_station_browser import PATIENCE_MS
from playwright.sync_api import expect

from station.page.texts import Texts
from station.recording import Event, EventKind, RecordingWriter
from station.store import Calibration, Pass, PassState, Recording, Replay, the
from station.store.callers import Scope

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
NOON_NS = 1_782_907_200_000_000_000
EVIL = "<img src=x onerror=alert(1)>"
WIDTH, HEIGHT = 64, 48


def write(path, frames=3):
    path.parent.mkdir(parents=True, exist_ok=True)
    metadata = {"session": {"id": EVIL}}
    with RecordingWriter(path, metadata=metadata) as writer:
        writer.write_event("left", Event(EventKind.FRAMES_LOST, NOON_NS, EVIL, 2, 1))
        for number in range(1, frames + 1):
            at = NOON_NS + number * 10**9
            dark = memoryview(bytes(WIDTH * HEIGHT))
            writer.write_frame("left", number, at, at, dark, WIDTH, HEIGHT)


@pytest.fixture(scope="module")
def filled(paged):
    """Three recordings: of a pass, an upload, and one that runs."""
    root = paged.station.layout.root
    for name in ("own", "upload.1"):
        write(root / "recordings" / f"{name}.mcap")
    kept = {"sensor": "left", "recovered": False, "opened_at": NOON}
    closed = kept | {"closed_at": NOON, "recorded": 3, "lost": 0, "files": 1}
    with paged.store.change() as session:
        session.add(Pass(id="p1", state=PassState.DONE, opened_at=NOON, train=EVIL))
        session.add(
            Calibration(
                id="c1",
                state="ready",
                sensor="left",
                target="t",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=NOON,
                job_id="j",
            )
        )
        session.flush()
        session.add_all([
            Recording(id="own", path="recordings/own.mcap", pass_id="p1", summary=EVIL, **closed),
            Recording(id="upload.1", path="recordings/upload.1.mcap", sha256="00", **closed),
            Recording(id="running", path="recordings/running.mcap", **kept),
        ])
    return paged


@pytest.fixture
def seen(filled):
    """Return what a browser with some scope sees."""

    def get(address, *scopes):
        with filled.browser(filled.key(*scopes or (Scope.READ,))) as browser:
            return browser.get(address)

    return get


def test_list_shows_what_is_looked_for_and_says_where_nothing_is(seen):
    assert all(name in seen("/recordings").text for name in ("own", "upload.1", "running"))
    found = seen("/recordings?kind=running&name=&sensor=&from=&to=").text
    assert 'href="/recordings/running"' in found
    assert 'href="/recordings/own"' not in found
    assert "No recording is like that." in seen("/recordings?sensor=right").text


@pytest.mark.parametrize("query", ["kind=odd", "from=yesterday", "before=nowhere"])
def test_a_search_that_makes_no_sense_is_refused_in_words(seen, query):
    reply = seen(f"/recordings?{query}")
    assert reply.status_code == 422
    assert "<h1>" in reply.text


def test_nothing_that_somebody_wrote_is_markup(seen):
    for address in ("/recordings", "/recordings/own", "/recordings/own/contents"):
        assert "<img src=x" not in seen(address).text
    assert "&lt;img src=x onerror=alert(1)&gt;" in seen("/recordings/own").text
    assert "&lt;img src=x onerror=alert(1)&gt;" in seen("/recordings/own/contents").text


def test_scripts_show_what_somebody_wrote_as_text(filled, page):
    page.goto(f"{filled.url}/login")
    page.get_by_label("Key").fill(filled.key(Scope.READ))
    page.get_by_role("button", name="Log in").click()
    page.wait_for_url("**/now")
    page.goto(f"{filled.url}/recordings/own")
    page.get_by_text("Events", exact=True).last.click()
    expect(page.get_by_role("cell", name=EVIL)).to_be_visible(timeout=PATIENCE_MS)
    page.locator(".timeline canvas").hover(position={"x": 4, "y": 88})
    expect(page.locator(".timeline-said")).to_contain_text(EVIL)
    assert page.locator("img[src=x]").count() == 0


def test_unknown_recordings_are_not_found_on_every_address(seen):
    for rest in ("", "/contents", "/timeline", "/replays/r1", "/replays/r1/outcome"):
        assert seen(f"/recordings/nobody{rest}").status_code == 404


def test_a_recording_that_runs_is_shown_without_frames(seen):
    text = seen("/recordings/running").text
    assert "It is still being recorded" in text
    assert 'id="player"' not in text
    assert seen("/recordings/running/timeline").status_code == 409


def test_time_line_has_the_frames_and_events_of_the_recording(seen):
    told = seen("/recordings/own/timeline").json()
    assert (told["frames"], sum(told["bins"]["frames"]), told["seconds"]) == (3, 3, 3.0)
    assert [(each["kind"], each["detail"]) for each in told["events"]] == [("frames_lost", EVIL)]


def test_events_of_a_recording_without_frames_are_shown_as_text(seen):
    text = seen("/recordings/own/events").text
    assert "frames lost" in text
    assert "&lt;img src=x" in text


def test_every_kind_of_event_has_its_words():
    texts = Texts.of()
    assert all(f"recordings.events.{kind}" in texts for kind in EventKind)


def test_who_may_only_read_sees_no_button_that_would_be_refused(seen, filled):
    for address in ("/recordings", "/recordings/upload.1"):
        text = seen(address).text
        assert 'id="upload"' not in text
        assert "/delete" not in text
        assert "/replays/new" not in text
    assert "needs the scope calibrate" in seen("/recordings/own").text
    with filled.browser(filled.key(Scope.READ)) as browser:
        assert browser.get("/recordings/own/replays/new").status_code == 403
        form = {"calibration": "c1", "reference": "S1002"}
        assert browser.post("/recordings/own/replays", data=form).status_code == 403
        assert browser.post("/recordings/upload.1/delete").status_code == 403


def test_measuring_again_is_ordered_and_leads_to_what_comes_of_it(filled):
    with filled.browser(filled.key(Scope.READ, Scope.CALIBRATE)) as browser:
        assert "c1" in browser.get("/recordings/own/replays/new").text
        form = {"calibration": "c1", "reference": "LMA"}
        reply = browser.post("/recordings/own/replays", data=form)
        assert reply.status_code == 204
        address = reply.headers["HX-Redirect"]
        with filled.store.look() as session:
            row = the(session, Replay, address.rpartition("/")[2])
        assert (row.steps, row.calibrations) == ({"steps": [["own"]]}, {"left": "c1"})
        assert row.reference == "LMA"
        waiting = browser.get(address)
        assert "Waits for the worker" in waiting.text
        assert browser.get(address.replace("own", "upload.1")).status_code == 404
        assert browser.post(f"{address}/cancel").status_code == 204
        outcome = browser.get(f"{address}/outcome").text
        assert "It was cancelled" in outcome
        assert "hx-trigger" not in outcome


@pytest.mark.parametrize(
    ("form", "status"),
    [
        ({"calibration": "c1", "reference": "mine"}, 422),
        ({"calibration": "", "reference": "LMA"}, 422),
        ({"calibration": "nobody", "reference": "LMA"}, 404),
        ({"calibration": "c1", "rig_calibration": "g1", "reference": "LMA"}, 422),
        ({"rig_calibration": "nobody", "reference": "LMA"}, 404),
        ({}, 422),
    ],
)
def test_orders_that_cannot_be_are_refused(filled, form, status):
    with filled.browser(filled.key(Scope.READ, Scope.CALIBRATE)) as browser:
        assert browser.post("/recordings/own/replays", data=form).status_code == status


def test_an_uploaded_recording_is_deleted_and_the_stations_own_is_not(filled):
    with filled.browser(filled.key(Scope.READ, Scope.CALIBRATE)) as browser:
        refused = browser.post("/recordings/own/delete")
        assert refused.status_code == 409
        assert "it makes way by" in refused.text
        reply = browser.post("/recordings/upload.1/delete")
        assert (reply.status_code, reply.headers["HX-Redirect"]) == (204, "/recordings")
        gone = browser.get("/recordings/upload.1").text
    assert "deleted by" in gone
    assert "Its files are not on the disk any more" in gone
    assert not (filled.station.layout.root / "recordings" / "upload.1.mcap").exists()
