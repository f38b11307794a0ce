"""Shows that the recordings page can be walked and worked in a browser: searched, looked through,
measured again, uploaded to and deleted from.  Any complaint of the browser fails the test."""

import re
from pathlib import Path

import httpx
import pytest
from demo_station_browser import logged_in as log_in
from playwright.sync_api import expect

LOOKS = pytest.mark.parametrize(
    ("scheme", "size"),
    [("light", (1280, 800)), ("dark", (820, 1180))],
    ids=["light on a desk", "dark on a tablet"],
)
RECORDING = "pass.rb17-5.right"
OF_A_RIG = "pass.rb17-5.left-outer"
"""Its wheels are kept with the frames of the other sensor of its rig."""


def shown(page):
    return page.locator("#player")


def go_to(page, demo, path):
    page.goto(f"{demo.url}{path}")


def fits(page):
    """Tell whether nothing has to be scrolled to from side to side."""
    return page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@LOOKS
def test_a_recording_is_searched_and_looked_through(page, quiet_demo, axe, scheme, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.emulate_media(color_scheme=scheme)
    log_in(page, quiet_demo)
    go_to(page, quiet_demo, "/recordings")
    axe(page)
    assert fits(page)
    page.get_by_label("Name contains").fill("RB17-5")
    page.get_by_label("Sensor").select_option("right")
    page.get_by_role("button", name="Search").click()
    page.get_by_role("link", name=RECORDING).click()
    expect(shown(page)).to_have_attribute("data-shown", "1")
    expect(shown(page)).to_have_attribute("data-timeline-shown", "")
    axe(page)
    assert fits(page)
    walk_through_frames(page)
    read_events(page)


def walk_through_frames(page):
    last = shown(page).get_attribute("data-frames")
    page.get_by_role("button", name="Next frame").click()
    expect(shown(page)).to_have_attribute("data-shown", "2")
    stage = page.locator(".stage")
    stage.press("End")
    expect(shown(page)).to_have_attribute("data-shown", last)
    expect(page.locator(".stage-said")).to_contain_text("stripe points")
    stage.press("ArrowLeft")
    expect(shown(page)).to_have_attribute("data-shown", str(int(last) - 1))
    page.locator(".slider").fill("2")
    expect(shown(page)).to_have_attribute("data-shown", "2")
    page.get_by_role("button", name="Go to frame 3").click()
    expect(shown(page)).to_have_attribute("data-shown", "3")
    page.get_by_label("Show the stripe").uncheck()
    page.get_by_label("Brighten").check()
    page.get_by_role("spinbutton").fill("1")
    page.get_by_role("spinbutton").press("Enter")
    expect(shown(page)).to_have_attribute("data-shown", "1")
    page.get_by_label("Speed").select_option("10")
    page.get_by_role("button", name="Play").click()
    expect(shown(page)).to_have_attribute("data-shown", last)
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    page.get_by_role("button", name=re.compile("^Show frame")).first.click()
    expect(shown(page)).to_have_attribute("data-shown", "1")


def read_events(page):
    last = shown(page).get_attribute("data-frames")
    line = page.get_by_role("img", name=re.compile(f"{last} frames in .* 4 wheels"))
    box = line.bounding_box()
    line.click(position={"x": box["width"] - 2, "y": 20})
    expect(shown(page)).to_have_attribute("data-shown", last)
    line.press("ArrowLeft")
    expect(shown(page)).not_to_have_attribute("data-shown", last)
    page.get_by_text("Events", exact=True).last.click()
    events = page.get_by_role("table", name="What happened while it was recorded")
    expect(events).to_contain_text("recording began")


@LOOKS
def test_both_readings_stand_side_by_side(page, quiet_demo, axe, scheme, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.emulate_media(color_scheme=scheme)
    log_in(page, quiet_demo)
    go_to(page, quiet_demo, f"/recordings/{RECORDING}")
    row = page.get_by_role("row").filter(has_text="done")
    row.get_by_role("link").click()
    expect(page.get_by_text(re.compile(r"\d+ of \d+ quantities agree"))).to_be_visible()
    page.get_by_role("button", name="Show both profiles").first.click()
    expect(page.get_by_text("The profiles differ by at most")).to_be_visible()
    expect(page.locator(".profiles canvas")).to_have_count(2)
    axe(page)
    assert fits(page)


def test_a_recording_is_measured_again_as_one_watches(page, served_demo):
    log_in(page, served_demo, "calibrate")
    go_to(page, served_demo, f"/recordings/{OF_A_RIG}")
    page.get_by_role("button", name="Choose a calibration…").click()
    page.get_by_role("button", name="Measure again").click()
    page.wait_for_url("**/replays/*")
    expect(page.get_by_text(re.compile(r"quantities agree"))).to_be_visible(timeout=120_000)
    expect(page.get_by_role("heading", name="Wheel of frame")).to_have_count(4)
    expect(page.get_by_text("rig calibration")).to_have_count(1)  # as it was measured before
    # Alone the sensor sees but a part of the wheel: what it cannot tell is said so.
    expect(page.get_by_role("cell", name="cannot be told").first).to_be_visible()


def test_a_pass_is_measured_again_with_another_calibration_of_its_rig(page, served_demo, axe):
    other = rig_that_stands_elsewhere(served_demo)
    log_in(page, served_demo, "calibrate")
    go_to(page, served_demo, f"/recordings/{OF_A_RIG}")
    page.get_by_role("button", name="Choose a calibration…").click()
    page.get_by_label("Calibration of rig left").select_option(other)
    axe(page)
    page.get_by_role("button", name="Measure the pass again").click()
    page.wait_for_url("**/replays/*")
    expect(page.get_by_text(re.compile(r"\d+ of 32 quantities agree"))).to_be_visible(
        timeout=120_000
    )
    expect(page.get_by_role("heading", name="Wheel of frame")).to_have_count(4)
    thickness = page.get_by_role("row", name="Flange thickness Sd, 10 mm above").first
    expect(thickness.locator("td").nth(4)).to_have_text(re.compile("[1-9]"))  # it is another
    expect(page.get_by_role("cell", name="cannot be told")).to_have_count(0)
    assert fits(page)
    page.get_by_role("link", name="pass.rb17-5.left-inner").click()
    expect(page.get_by_role("cell", name=f"rig calibration {other}")).to_be_visible()
    # What was measured again stands behind the readings of the pass.
    expect(page.get_by_role("row").filter(has_text="WS-")).to_have_count(4)


def rig_that_stands_elsewhere(demo):
    """Put in a calibration by which a sensor of the rig stands 1 mm aside; return its name."""
    calibrations = f"{demo.url}/v1/rig-calibrations"
    key = {"Authorization": f"Bearer {demo.keys['calibrate']}"}
    present = demo.data.told.calibrations["rig"]
    document = httpx.get(f"{calibrations}/{present}", headers=key).json()["document"]
    document["sensors"][1]["translation_mm"][1] += 1.0
    reply = httpx.post(f"{calibrations}/files", headers=key, json=document)
    return reply.raise_for_status().json()["id"]


def test_a_recording_is_uploaded_and_deleted(page, quiet_demo, tmp_path, expected_failures, axe):
    expected_failures += ["422", "415", "400"]  # what is no recording is refused
    log_in(page, quiet_demo, "calibrate")
    go_to(page, quiet_demo, "/recordings")
    page.get_by_role("button", name="Upload", exact=True).click()
    expect(page.locator("#upload")).to_contain_text("Choose a file first.")
    send(page, tmp_path / "no.mcap", b"no recording at all")
    expect(page.locator("#upload")).to_contain_text("not a recording")
    send(page, tmp_path / "good.mcap", recorded(quiet_demo))
    page.get_by_role("link", name="Open it").click()
    expect(shown(page)).to_have_attribute("data-shown", "1")
    axe(page)
    page.on("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Delete").click()
    page.wait_for_url("**/recordings")
    expect(page.get_by_text("deleted", exact=True).first).to_be_visible()


def recorded(demo):
    """Fetch a recording of the station's own, which it does not know as an upload."""
    key = {"Authorization": f"Bearer {demo.keys['read']}"}
    return httpx.get(f"{demo.url}/v1/recordings/{RECORDING}/files/1", headers=key).content


def send(page, path: Path, content: bytes):
    path.write_bytes(content)
    page.get_by_label("File (.mcap)").set_input_files(path)
    page.get_by_role("button", name="Upload", exact=True).click()
