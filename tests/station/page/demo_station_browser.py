"""A browser before the demo station: what it complains of fails a test, unless the test said so."""

import re
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

from axe_playwright_python.sync_playwright import Axe
from demo_station_serving import Demo
from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Page,
    Request,
    Response,
    expect,
    sync_playwright,
)

CHROMIUM = Path("/usr/bin/chromium")
_ARGUMENTS = [
    "--no-sandbox",  # tests run as root in containers
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
_GRAVE = {"serious", "critical"}
PATIENCE_MS = 60_000.0
"""Of every wait, for a busy host; what has happened is not waited for."""


@contextmanager
def chromium_running() -> Generator[Browser]:
    """Run Debian's Chromium, headless."""
    assert CHROMIUM.exists(), f"no browser at {CHROMIUM}; install it: apt-get install chromium"
    expect.set_options(timeout=PATIENCE_MS)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=_ARGUMENTS, timeout=2.0 * PATIENCE_MS
        )
        try:
            yield browser
        finally:
            browser.close()


@dataclass
class Complaints:
    """What went wrong on a page: console errors, uncaught ones, requests that failed."""

    expected: list[str]
    """Regular expressions; what one of them is found in was declared by the test."""
    heard: list[str] = field(default_factory=list)

    def listen(self, page: Page) -> None:
        """Hear all that the page and its workers complain of."""
        page.on("console", self._console)
        page.on("pageerror", lambda error: self.heard.append(f"uncaught: {error}"))
        page.on("requestfailed", self._failed)
        page.on("response", self._answered)

    @property
    def unexpected(self) -> list[str]:
        """What nobody had declared."""
        return [
            each for each in self.heard if not any(re.search(one, each) for one in self.expected)
        ]

    def _console(self, message: ConsoleMessage) -> None:
        if message.type == "error":
            self.heard.append(f"console: {message.text} ({message.location.get('url', '')})")

    def _failed(self, request: Request) -> None:
        # A page that is left takes back what it still asked for, as streams of events always are.
        if request.failure != "net::ERR_ABORTED":
            self.heard.append(f"request: {request.method} {request.url}: {request.failure}")

    def _answered(self, response: Response) -> None:
        if response.status >= 400:
            method = response.request.method
            self.heard.append(f"response: {response.status} to {method} {response.url}")


def logged_in(page: Page, demo: Demo, scope: str = "read") -> Page:
    """Log a page in at a demo station with the key of a scope, as a person does; return it."""
    page.goto(f"{demo.url}/login")
    page.locator("input[name=key]").fill(demo.keys[scope])
    page.locator("input[name=key]").press("Enter")
    page.wait_for_url(lambda url: urlsplit(url).path != "/login")
    return page


def ensure_accessible(page: Page, *, but: Iterable[str] = ()) -> None:
    """Fail where axe finds a serious or critical fault, naming the nodes.

    Parameters
    ----------
    but
        Rules that are not asked, each with its reason beside the call.
    """
    asked = {rule: {"enabled": False} for rule in but}
    found = Axe().run(page, options={"resultTypes": ["violations"], "rules": asked}).response
    grave = [each for each in found["violations"] if each["impact"] in _GRAVE]
    told = [
        f"{each['impact']} {each['id']}: {each['help']}: {node['target']} {node['html'][:160]}"
        for each in grave
        for node in each["nodes"]
    ]
    assert not told, f"{page.url} has faults that lock people out:\n" + "\n".join(told)
