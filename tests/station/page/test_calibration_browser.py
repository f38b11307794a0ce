"""Calibrating in a browser: the pages are walked, pressed and looked at, dark and light."""

import re
from contextlib import contextmanager
from datetime import UTC, datetime

import pytest
from demo_station_browser import logged_in as log_in
from demo_station_quiet import LIVE_PICTURES, LIVE_SESSION
from demo_station_serving import served_quietly
from demo_station_truth import RIGHT
from playwright.sync_api import expect

from station.store import (
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Store,
    add_job,
    end,
    report_progress,
    sqlite_url,
    start,
    the,
)

WIDE, TABLET = {"width": 1280, "height": 800}, {"width": 820, "height": 1180}
FIRST_VIEW_BYTES = 150_000


@pytest.fixture(scope="module")
def own(demo_data, tmp_path_factory):
    """A station of these tests alone: they press what can be pressed."""
    with served_quietly(demo_data, tmp_path_factory.mktemp("pressed")) as demo:
        yield demo


@contextmanager
def weighed(page):
    """Count what comes over the wire."""
    sizes = []
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    session.on("Network.loadingFinished", lambda each: sizes.append(each["encodedDataLength"]))
    yield sizes
    session.detach()


def fits(page):
    return page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_reports_are_read_and_decided_in_the_light(page, own, axe):
    page.set_viewport_size(WIDE)
    log_in(page, own, "calibrate")
    with weighed(page) as sizes:
        page.goto(f"{own.url}/calibration")
        page.wait_for_load_state("load")
    assert sum(sizes) <= FIRST_VIEW_BYTES
    expect(page.locator("#state .cards article")).to_have_count(4)
    axe(page)
    page.goto(f"{own.url}/calibrations/{own.data.told.calibrations['right-1']}")
    expect(page.locator("#overlay .mark-seen").first).to_be_attached()
    expect(page.locator("#dots-histogram svg")).to_be_visible()
    expect(page.locator("#sheet-map canvas").first).to_be_visible()
    expect(page.locator("#comparison-map .badge")).to_be_visible()
    expect(page.locator("#shifts tbody tr").first).to_be_visible()
    axe(page)
    page.get_by_role("button", name="Before", exact=True).click()
    expect(page.locator("#overlay .mark-corrected")).to_have_count(0)
    page.get_by_role("button", name="After", exact=True).click()
    expect(page.locator("#overlay .mark-seen")).to_have_count(0)
    page.get_by_role("button", name="Both", exact=True).click()
    near = page.locator("#overlay .mark-seen").last.get_attribute("d")
    page.locator("#magnified").select_option("200")
    assert page.locator("#overlay .mark-seen").last.get_attribute("d") != near
    view = page.locator("#overlay svg").get_attribute("viewBox")
    page.locator("#overlay").press("+")
    assert page.locator("#overlay svg").get_attribute("viewBox") != view
    page.locator("#overlay").press("ArrowLeft")
    page.locator("#picture-table button").nth(2).click()
    expect(page.locator("#picture-table tbody tr").nth(2)).to_have_attribute("aria-current", "true")
    page.get_by_label("Reason").fill("<img src=x onerror=alert(1)>")
    page.get_by_role("button", name="Refuse").click()
    expect(page.locator("p.warning", has_text="<img src=x onerror=alert(1)>")).to_be_visible()


def test_a_guided_session_in_the_dark_on_a_tablet(page, own, axe):
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size(TABLET)
    log_in(page, own, "calibrate")
    page.goto(f"{own.url}/calibration/sessions/{LIVE_SESSION}")
    poses = page.locator("#guided tbody").last.locator("tr")
    expect(poses).to_have_count(LIVE_PICTURES)
    expect(page.locator("#guided .do")).to_have_text(re.compile("^(Hold the target|Enough)"))
    assert page.locator("#guided .cell").count() == 48
    axe(page)
    assert fits(page)
    page.get_by_role("button", name="Take a picture").click()
    expect(poses).to_have_count(LIVE_PICTURES + 1)
    page.once("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Finish the session").click()
    expect(page.get_by_role("heading", name="Solve a calibration")).to_be_visible()
    axe(page)
    page.get_by_role("button", name="Solve", exact=True).click()
    page.wait_for_url("**/calibrations/*")
    expect(page.get_by_role("heading", name="Verdict")).to_be_visible()


def test_drift_and_a_night_that_asks(page, own, axe):
    page.set_viewport_size(TABLET)
    log_in(page, own, "calibrate")
    page.goto(f"{own.url}/calibration/sensors/{RIGHT}")
    expect(page.locator("#drift-mid canvas")).to_be_visible()
    axe(page)
    assert fits(page)
    page.goto(f"{own.url}/calibration")
    page.get_by_role("link", name="Look and answer").first.click()
    page.get_by_label("Reason").fill("the board had slipped")
    page.get_by_role("button", name="Refuse it").click()
    expect(page.get_by_text("the board had slipped")).to_be_visible()
    expect(page.get_by_role("button", name="Refuse it")).to_have_count(0)


def test_a_session_is_opened_by_the_form(page, own):
    page.set_viewport_size(TABLET)
    log_in(page, own, "calibrate")
    page.goto(f"{own.url}/calibration")
    assert fits(page)
    page.get_by_label("With").select_option("sensor:left-inner")
    page.get_by_label("Name of the session").fill("by-form")
    page.get_by_role("button", name="Open the session").click()
    page.wait_for_url("**/calibration/sessions/by-form")
    expect(page.locator("#guided .do")).to_be_visible()
    expect(page.locator("#guided")).to_contain_text("No picture yet.")


def solving(own, name):
    """Have a calibration be solved, by a worker that is not there."""
    at = datetime.now(UTC)
    with own_store(own) as store, store.change() as session:
        start(add_job(session, f"job-{name}", JobKind.CALIBRATE, name, at=at), at=at)
        session.add(
            Calibration(
                id=name,
                state=CalibrationState.SOLVING,
                sensor=RIGHT,
                target="dots:6x7:24",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=at,
                job_id=f"job-{name}",
            )
        )


@contextmanager
def own_store(own):
    store = Store.open(sqlite_url(own.folder / "data" / "station.sqlite"))
    yield store
    store.close()


def progress(own, name, part, doing):
    with own_store(own) as store, store.change() as session:
        report_progress(session, f"job-{name}", part, doing)


def failed(own, name):
    at = datetime.now(UTC)
    with own_store(own) as store, store.change() as session:
        row = the(session, Calibration, name)
        row.state, row.reason = CalibrationState.FAILED, "the light was out"
        end(the(session, Job, f"job-{name}"), JobState.FAILED, at=at, error="the light was out")


@pytest.mark.parametrize("refused", [False, True], ids=["streamed", "asked for"])
def test_a_solve_is_followed_until_it_ends(page, own, axe, refused, expected_failures):
    name, asked = f"solving-{refused}".lower(), []
    solving(own, name)
    if refused:
        expected_failures.append("503")
        page.route("**/v1/jobs/*/events", lambda route: route.fulfill(status=503))
    log_in(page, own, "read")
    page.on(
        "request", lambda each: asked.append(each.url) if each.url.endswith("/solving") else None
    )
    with page.expect_response("**/v1/jobs/*/events"):
        page.goto(f"{own.url}/calibrations/{name}")
    axe(page)
    for part, doing in ((0.25, "picture 3 of 12"), (0.75, "solving")):
        asked.clear()  # a stream that comes late is asked for meanwhile
        progress(own, name, part, doing)
        expect(page.locator("#solving .hint")).to_have_text(
            f"{part:.0%}"[:-1] + f"\u202f% · {doing}"
        )
    assert bool(asked) == refused  # what is streamed is not asked for besides
    failed(own, name)
    expect(page.get_by_role("alert")).to_contain_text("the light was out")
    expect(page.locator("#solving")).to_have_count(0)
