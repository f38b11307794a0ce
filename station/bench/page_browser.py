"""A browser before the station's pages, as the benches use it."""

import re
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from station.errors import InputUnusable, StationError

if TYPE_CHECKING:  # of the tests' packages: a station needs no browser
    from playwright import sync_api

_CHROMIUM: Final = Path("/usr/bin/chromium")
_ARGUMENTS: Final = (
    "--no-sandbox",  # benches run as root in containers
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
_PATIENCE_MS = 60_000.0
_SETTLED_MS = 1000.0
_LOOK_MS = 50.0
_INTERACTIVE: Final = "() => performance.getEntriesByType('navigation')[0].domContentLoadedEventEnd"
_FETCHED: Final = re.compile(r"/wheels/\d+/drawing$")
_DRAWN: Final = "() => performance.getEntriesByName('profile-drawn').at(0)?.duration ?? null"


@dataclass(frozen=True, slots=True)
class Visit:
    """A page as it was opened for the first time."""

    interactive_ms: float
    """From the call to the end of all its scripts: whatever is pressed then is heard."""
    wire_bytes: int
    """All that came until a second later, headers included."""


class Browser:
    """Opens pages of one station, each time as if for the first."""

    def __init__(self, chromium: "sync_api.Browser") -> None:
        self._chromium = chromium
        self._url = ""
        self._cookies: Any = None

    def log_in(self, url: str, key: str) -> None:
        """Log in at a station by a key; later visits are of who did."""
        context = self._chromium.new_context()
        page = context.new_page()
        page.goto(f"{url}/login")
        page.locator("input[name=key]").fill(key)
        with page.expect_navigation():
            page.locator("input[name=key]").press("Enter")
        self._url, self._cookies = url, context.storage_state()
        context.close()

    def visit(self, address: str) -> Visit:
        """Open a page with nothing kept from before."""
        with self._page() as page:
            wire, came = page.context.new_cdp_session(page), list[int]()
            wire.send("Network.enable")
            wire.on("Network.loadingFinished", lambda told: came.append(told["encodedDataLength"]))
            page.goto(f"{self._url}{address}")
            page.wait_for_timeout(_SETTLED_MS)
            return Visit(float(page.evaluate(_INTERACTIVE)), int(sum(came)))

    def profile_drawn_ms(self, address: str, drawing: str) -> float:
        """Open the page of a wheel; return how long drawing a profile took, ms.

        Parameters
        ----------
        drawing
            What the page is to draw, as it would fetch it.
        """
        with self._page() as page:
            page.route(_FETCHED, lambda route: route.fulfill(body=drawing))
            page.goto(f"{self._url}{address}")
            # Not by the browser's own waiting: that evaluates text, which the page does not let it.
            until_s = time.monotonic() + _PATIENCE_MS / 1e3
            while (took_ms := page.evaluate(_DRAWN)) is None:
                if time.monotonic() > until_s:
                    raise StationError(f"{address} drew no profile within {_PATIENCE_MS / 1e3:g} s")
                page.wait_for_timeout(_LOOK_MS)
            return float(took_ms)

    @contextmanager
    def _page(self) -> Generator["sync_api.Page"]:
        context = self._chromium.new_context(
            storage_state=self._cookies,
            locale="en-US",
            viewport={"width": 1280, "height": 800},
        )
        context.set_default_timeout(_PATIENCE_MS)
        yield context.new_page()
        context.close()


@contextmanager
def browser() -> Generator[Browser]:
    """Run Debian's Chromium, headless.

    Raises
    ------
    InputUnusable
        If it is not installed, or nothing to drive it with is.
    """
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415  of the tests' packages
    except ImportError as error:
        raise InputUnusable(
            "this bench drives a browser by playwright, which is not installed; install it: "
            "pip install playwright"
        ) from error
    if not _CHROMIUM.exists():
        raise InputUnusable(
            f"no browser at {_CHROMIUM}; this bench needs one: apt-get install chromium"
        )
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=_CHROMIUM, args=_ARGUMENTS)
        try:
            yield Browser(chromium)
        finally:
            chromium.close()
