"""A person comes in with a browser, turns the page dark and its times to UTC, and goes out."""

import pytest
from paged_station import ENVIRONMENT_KEY
from playwright.sync_api import expect

from station.store.callers import Scope

LARGEST_FIRST_VIEW_BYTES = 150_000


def log_in(page, paged, key, path="/set-up"):
    page.goto(f"{paged.url}{path}")
    page.get_by_label("Key").fill(key)
    page.get_by_role("button", name="Log in").click()
    page.wait_for_url(f"**{path}")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_login_and_a_missing_page_are_accessible(page, paged, axe, scheme, expected_failures):
    expected_failures.append(r"\b404\b")
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": 820, "height": 1180})
    page.goto(f"{paged.url}/login")
    expect(page.get_by_label("Key")).to_be_focused()
    axe(page)
    log_in(page, paged, ENVIRONMENT_KEY)
    page.goto(f"{paged.url}/nowhere/<b>bold</b>")
    assert page.locator("main b").count() == 0
    axe(page)
    page.get_by_role("link", name="Back to the station").click()
    page.wait_for_url("**/now")


def test_a_bad_key_is_said_at_the_field_and_the_next_one_goes_where_the_first_was_to(
    page, paged, axe, expected_failures
):
    expected_failures.append(r"\b401\b")
    page.goto(f"{paged.url}/set-up/limits")
    page.get_by_label("Key").fill("no key")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert")).to_contain_text("does not accept this key")
    expect(page.get_by_label("Key")).to_have_attribute("aria-describedby", "refused")
    axe(page)
    page.get_by_label("Key").fill(ENVIRONMENT_KEY)
    page.keyboard.press("Enter")
    page.wait_for_url("**/set-up/limits")


def test_dark_and_utc_stay_as_they_were_told_on_every_page(page, paged):
    page.emulate_media(color_scheme="light")
    log_in(page, paged, paged.key(Scope.READ))
    ground = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.get_by_role("button", name="Dark").click()
    page.get_by_role("button", name="UTC").click()
    page.goto(f"{paged.url}/set-up/storage")
    expect(page.get_by_role("button", name="Dark")).to_have_attribute("aria-pressed", "true")
    expect(page.get_by_role("button", name="UTC")).to_have_attribute("aria-pressed", "true")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != ground
    assert page.evaluate("document.documentElement.dataset.times") == "utc"


def test_the_keyboard_comes_past_the_navigation_and_round(page, paged):
    log_in(page, paged, paged.key(Scope.READ))
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the content")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#main")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Sensors")).to_be_focused()


def test_who_logs_out_is_at_the_login_and_the_way_back_is_closed(page, paged):
    log_in(page, paged, paged.key(Scope.READ))
    page.get_by_role("button", name="Log out").click()
    page.wait_for_url("**/login")
    assert page.context.cookies() == []
    page.go_back()
    page.wait_for_url("**/login?next=/set-up")


def test_the_first_view_is_small(page, paged):
    log_in(page, paged, paged.key(Scope.ADMIN))
    page.goto(f"{paged.url}/set-up", wait_until="networkidle")
    loaded = page.evaluate(
        "performance.getEntriesByType('resource').reduce((sum, one) => sum + one.encodedBodySize, "
        "performance.getEntriesByType('navigation')[0].encodedBodySize)"
    )
    assert 0 < loaded < LARGEST_FIRST_VIEW_BYTES
