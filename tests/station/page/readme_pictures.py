"""The README's pictures of the page: which there are, how they are taken, when they have aged."""

import time
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

FOLDER = Path(__file__).resolve().parents[3] / "station" / "page" / "pictures"
SIZES = {"wide": (1280, 800), "tablet": (820, 1180)}
_PATIENCE_S = 60.0
_REST_MS = 300
"""What still comes in after so long a rest was not asked for at once."""
_NOTHING_COMES = """() =>
    [...document.images].every((image) => image.complete) &&
    ![...document.querySelectorAll("main *")].some((each) =>
        !each.children.length && each.textContent.trim() === "Loading…" &&
        each.checkVisibility() && each.getBoundingClientRect().top < innerHeight)
"""
_SCALE = 0.625
_QUALITY = 72
_BLOCK_PX = 20
_UNLIKE_COUNTS = 20.0
"""A block that differs by more shows something else: a word more or less changes it by half."""


@dataclass(frozen=True)
class View:
    """One picture: what is shown, and what must be there before it is taken."""

    name: str
    address: str
    waits_for: str

    def file(self, size: str) -> Path:
        return FOLDER / f"{self.name}-{size}.webp"


def taken(page, url, view, size):
    """Return what a person sees at first sight, once it stands still, small."""
    width, height = SIZES[size]
    page.set_viewport_size({"width": width, "height": height})
    page.goto(url + view.address)
    page.locator(view.waits_for).first.wait_for()
    before, now = None, _seen(page)
    until_s = time.monotonic() + _PATIENCE_S
    while before is None or unlike_share(before, now) > 0.0 or not _complete(page):
        assert time.monotonic() < until_s, f"{view.address} does not come to rest"
        page.wait_for_timeout(_REST_MS)
        before, now = now, _seen(page)
    return now


def _seen(page):
    shot = np.frombuffer(page.screenshot(animations="disabled"), np.uint8)
    picture = cv2.imdecode(shot, cv2.IMREAD_COLOR)
    return cv2.resize(picture, None, fx=_SCALE, fy=_SCALE, interpolation=cv2.INTER_AREA)


def _complete(page):
    """Tell whether nothing in sight still comes; what lies below is loaded when it is reached."""
    return page.evaluate(_NOTHING_COMES)


def keep(picture, path):
    path.parent.mkdir(exist_ok=True)
    cv2.imwrite(str(path), picture, [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])


def kept(path):
    return cv2.imread(str(path), cv2.IMREAD_COLOR)


def unlike_share(a, b):
    """Return the share of blocks that show something else; 1 where the sizes differ."""
    if a.shape != b.shape:
        return 1.0
    size = (a.shape[1] // _BLOCK_PX, a.shape[0] // _BLOCK_PX)
    small = [cv2.resize(each, size, interpolation=cv2.INTER_AREA).astype(float) for each in (a, b)]
    differs = np.abs(small[0] - small[1]).max(axis=2) > _UNLIKE_COUNTS
    return float(differs.mean())
