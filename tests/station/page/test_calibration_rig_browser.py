"""What the reports of rigs, and recalibrations that ask, look like in a browser.

They are looked at alone: the station is that of all tests which change nothing.
"""

import re

from demo_station_browser import logged_in as log_in
from demo_station_truth import INNER, OUTER
from playwright.sync_api import expect

TABLET = {"width": 820, "height": 1180}


def fits(page):
    return page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_a_rig_shows_each_sensors_points_before_and_after(page, quiet_demo, axe):
    page.set_viewport_size(TABLET)
    log_in(page, quiet_demo, "read")
    page.goto(f"{quiet_demo.url}/rig-calibrations/{quiet_demo.data.told.calibrations['rig']}")
    expect(page.locator("#overlay .mark-seen").first).to_be_attached()
    expect(page.locator("#picture-table tbody button").first).to_contain_text(INNER)
    axe(page)
    assert fits(page)
    page.get_by_role("button", name="Before", exact=True).click()
    expect(page.locator("#overlay .mark-corrected")).to_have_count(0)
    page.get_by_role("button", name=OUTER, exact=True).click()
    expect(page.locator("#picture-table tbody button").first).to_contain_text(OUTER)
    expect(page.locator("#overlay svg")).to_have_attribute("aria-label", re.compile(OUTER))
    expect(page.locator("#overlay .mark-seen").first).to_be_attached()
    expect(page.locator("#overlay .mark-corrected")).to_have_count(0)  # still before
    expect(page.locator("#overlay image")).to_have_attribute("href", re.compile(f"{OUTER}/frames"))
    page.get_by_role("button", name="After", exact=True).click()
    expect(page.locator("#overlay .mark-seen")).to_have_count(0)
    expect(page.locator("#dots-histogram svg")).to_be_visible()


def test_who_answers_a_recalibration_sees_what_readings_would_be(page, quiet_demo, axe):
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size(TABLET)
    log_in(page, quiet_demo, "calibrate")
    page.goto(f"{quiet_demo.url}/calibration")
    page.get_by_role("link", name="Look and answer").first.click()
    expect(page.get_by_role("button", name="Refuse it")).to_be_visible()
    address = page.locator("#shifts").get_attribute("data-shifts")
    told = quiet_demo.ask(address).json()
    rows = page.locator("#shifts tbody tr")
    expect(rows).to_have_count(len(told["shifts"]))
    for place, shift in enumerate(told["shifts"]):
        text = f"{shift['shift_mm']:+.4f}".replace("-", "\N{MINUS SIGN}")
        expect(rows.nth(place)).to_contain_text(text)
        expect(rows.nth(place)).to_contain_text("within" if shift["within"] else "beyond")
    axe(page)
    assert fits(page)
    page.locator("#shifts").get_by_role("link", name="look at it").click()
    page.wait_for_url(f"**/wheels/{told['measurement']}")
