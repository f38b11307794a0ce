"""Shows the fleet's pages in a browser: from the disk, run by nobody, and readable by everybody."""

from datetime import timedelta

import pytest
from fleet_stations import BEGAN, fleet_of_two, night_of

from station.cli.main import build_app, run
from station.store import sqlite_url

HOSTILE = "<script>document.title='run'</script>"


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Pages of two stations, of which one and a wheelset have names that would be scripts."""
    folder = tmp_path_factory.mktemp("fleet")
    url = sqlite_url(folder / "fleet.sqlite")
    with fleet_of_two(folder, url) as (north, south):
        south.name = HOSTILE
        for number in range(12):
            north.train(number, axles=1, value=34.0 + 0.1 * number, wheelset=HOSTILE)
            at = BEGAN + timedelta(days=number, hours=5)
            south.train(number, axles=1, value=34.4, at=at, wheelset=HOSTILE)
        night_of(south)
        north.push()
        south.push()
        run(build_app("fleet"), ["fleet", "page", "--out", str(folder / "out"), "--url", url])
    return folder / "out"


@pytest.mark.parametrize(
    ("size", "scheme", "seen"),
    [
        ((1280, 800), "light", ("index.html", "wheels/*.html")),
        ((820, 1180), "dark", ("names/*.html", "wheels/*.html")),
    ],
    ids=["wide", "tablet"],
)
def test_axe_finds_nothing_serious_and_nothing_is_wider_than_the_window(
    page, axe, pages, size, scheme, seen
):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.emulate_media(color_scheme=scheme)
    for path in (path for pattern in seen for path in pages.glob(pattern)):
        page.goto(path.as_uri())
        axe(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0], path


def test_names_that_would_be_scripts_are_text_and_lead_to_their_wheel(page, pages):
    page.goto((pages / "index.html").as_uri())
    page.get_by_role("link", name=f"{HOSTILE}-0, left wheel").first.click()
    assert page.locator("h1").inner_text() == f"{HOSTILE}-0, left wheel"
    assert page.title() == f"{HOSTILE}-0, left wheel · Fleet"
    page.get_by_role("img", name="Flange height Sh: 24 values").wait_for()
    assert page.locator("script").count() == 0


def test_the_style_that_the_policy_allows_is_the_one_applied(page, pages):
    page.goto((pages / "index.html").as_uri())
    top = page.locator("header.top")
    assert top.evaluate("element => getComputedStyle(element).display") == "flex"


@pytest.mark.parametrize(
    "expected_failures", [["Content Security Policy", "violates the following"]], ids=["planted"]
)
def test_a_script_that_got_into_a_page_would_not_run(page, pages, tmp_path, expected_failures):
    text = (pages / "index.html").read_text().replace("<h1>", f"{HOSTILE}<h1>")
    (tmp_path / "planted.html").write_text(text)
    page.goto((tmp_path / "planted.html").as_uri())
    assert page.title() == "Overview · Fleet"
