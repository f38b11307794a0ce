"""The README's pictures show the page as it is: taken here, they are compared with those kept.

Times and ages differ from day to day, so likeness is asked of the whole, not of each letter.  With
TREADLINE_TAKE_PICTURES=1 in the environment they are taken anew.
"""

import os
import re
from pathlib import Path

import pytest
from demo_station_browser import logged_in
from readme_pictures import FOLDER, SIZES, View, keep, kept, taken, unlike_share

README = Path(__file__).resolve().parents[3] / "README.md"
MOST_UNLIKE = 0.08
"""Seen: 0.01 between two runs an hour apart, 0.25 and more between different pages."""
LARGEST_BYTES = 60_000
VIEWS = (
    View("now", "/now", "main img"),
    View("train", "/passes/rb17-6", "main .axle, main table"),
    View("wheel", "/wheels/57", "main svg, main canvas"),
    View("calibration", "/calibrations/demo000001", "main img, main canvas, main svg"),
    View("recording", "/recordings/pass.rb17-6.right", "main img"),
    View("set-up", "/set-up/limits", "main table, main svg"),
)


@pytest.fixture
def shown(page, quiet_demo):
    """A page at which somebody who may do all has logged in, by day."""
    page.emulate_media(color_scheme="light")
    return logged_in(page, quiet_demo, "admin")


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("view", VIEWS, ids=lambda view: view.name)
def test_a_picture_of_the_readme_shows_the_page_as_it_is(shown, quiet_demo, tmp_path, view, size):
    seen = taken(shown, quiet_demo.url, view, size)
    if os.environ.get("TREADLINE_TAKE_PICTURES"):
        keep(seen, view.file(size))
    keep(seen, tmp_path / "seen.webp")
    found = unlike_share(kept(tmp_path / "seen.webp"), kept(view.file(size)))
    assert found <= MOST_UNLIKE, (
        f"{view.address} has changed from {view.file(size)}: {found:.0%} of it is other than in "
        f"{tmp_path / 'seen.webp'}; look at both, then take it anew (TREADLINE_TAKE_PICTURES=1)"
    )


def test_pictures_of_different_pages_are_told_apart():
    pictures = [kept(view.file("wide")) for view in VIEWS]
    shares = [
        unlike_share(a, b) for i, a in enumerate(pictures) for b in pictures[i + 1 :]
    ]  # fmt: skip
    assert min(shares) > MOST_UNLIKE


def test_the_pictures_are_small_and_those_of_the_readme():
    files = {view.file(size) for view in VIEWS for size in SIZES}
    assert set(FOLDER.iterdir()) == files
    assert max(file.stat().st_size for file in files) <= LARGEST_BYTES
    named = re.findall(r"station/page/pictures/([\w-]+\.webp)", README.read_text("utf-8"))
    assert set(named) == {file.name for file in files}
