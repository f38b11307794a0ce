"""A demo station with real data, served with and without cameras, and a browser before it.

What is dear is made once for all tests of this folder, and ends with the last of them: later tests
are not to share their cores with a station, and Playwright leaves its event loop marked as running
in this thread, where others call `asyncio.run`.
"""

import os
import tempfile
from collections.abc import Callable, Generator
from contextlib import ExitStack
from pathlib import Path

import pytest
from demo_station_browser import PATIENCE_MS, Complaints, chromium_running, ensure_accessible
from demo_station_browser import logged_in as log_in
from demo_station_data import DemoData
from demo_station_serving import Demo, served, served_quietly
from paged_station import Paged
from playwright.sync_api import Browser, Locator, Page

from station.logs import log_as
from station.operations import DataLayout
from station.store import migrate

_HERE = Path(__file__).parent
_STACK = pytest.StashKey[ExitStack]()


@pytest.fixture(scope="session")
def of_this_folder(request):
    """Take what ends with the last test of this folder."""
    with ExitStack() as stack:
        request.config.stash[_STACK] = stack
        yield stack


@pytest.hookimpl(trylast=True)
def pytest_runtest_teardown(item, nextitem):
    if nextitem is None or not nextitem.path.is_relative_to(_HERE):
        item.config.stash.get(_STACK, ExitStack()).close()


def _folder(stack: ExitStack) -> Path:
    """Return a folder that goes with the last test: it is too large to be left lying."""
    return Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="treadline-demo-")))


@pytest.fixture(scope="session")
def demo_data(of_this_folder) -> DemoData:
    """Six weeks of a station with real readings of real pictures.

    TREADLINE_DEMO_DATA names a folder that keeps them from one run to the next; whoever changes
    what is told deletes it.
    """
    kept = os.environ.get("TREADLINE_DEMO_DATA")
    if kept is not None:
        return DemoData.kept(Path(kept).absolute())
    return DemoData.made(_folder(of_this_folder))


@pytest.fixture(scope="session")
def served_demo(demo_data, of_this_folder) -> Demo:
    """The station of all its processes, before simulated cameras."""
    return of_this_folder.enter_context(served(demo_data, _folder(of_this_folder)))


@pytest.fixture(scope="session")
def quiet_demo(demo_data, of_this_folder) -> Demo:
    """The API and the pages alone, with films in place of cameras."""
    return of_this_folder.enter_context(served_quietly(demo_data, _folder(of_this_folder)))


@pytest.fixture(scope="session")
def chromium(of_this_folder) -> Browser:
    """Debian's Chromium."""
    return of_this_folder.enter_context(chromium_running())


@pytest.fixture(autouse=True)
def clicks_wait_for_scripts(monkeypatch):
    """A person presses what has been there for a moment; what a button does comes with its script.

    Behind a link that was followed its text is there first, and a click in between does nothing.
    """
    click = Locator.click

    def click_once_loaded(self, **options):
        self.wait_for(state="attached")
        self.page.wait_for_load_state()
        click(self, **options)

    monkeypatch.setattr(Locator, "click", click_once_loaded)


@pytest.fixture
def expected_failures() -> list[str]:
    """Regular expressions of the complaints that a test expects of its page."""
    return []


@pytest.fixture
def page(chromium, expected_failures) -> Generator[Page]:
    """A page in a browser that knows nothing yet; complaints nobody expected fail the test."""
    # Colours that are on their way from light to dark are neither, and axe would say so.
    context = chromium.new_context(locale="en-US", reduced_motion="reduce")
    context.set_default_timeout(PATIENCE_MS)
    page = context.new_page()
    complaints = Complaints(expected_failures)
    complaints.listen(page)
    yield page
    context.close()
    assert not complaints.unexpected, "\n".join(["the page complained:", *complaints.unexpected])


@pytest.fixture
def logged_in(served_demo) -> Callable[[Page, str], Page]:
    """Return what logs a page in at the served station, as `logged_in(page, "operate")`."""
    return lambda page, scope="read": log_in(page, served_demo, scope)


@pytest.fixture
def axe() -> Callable[[Page], None]:
    """Return what fails on serious accessibility faults of a page."""
    return ensure_accessible


@pytest.fixture(scope="session")
def empty_store(tmp_path_factory) -> Path:
    """The file of a store in which nothing is yet."""
    layout = DataLayout(tmp_path_factory.mktemp("empty"))
    migrate(layout.store_url)
    return layout.store_file


@pytest.fixture(scope="module")
def paged(request, tmp_path_factory, empty_store) -> Generator[Paged]:
    """A station of a module's tests, which find what those before left.

    What a test gives as parameter is put in place of the settings of another one.
    """
    log_as("test")  # the library's own default draws every traceback in colour, which takes seconds
    root = tmp_path_factory.mktemp("paged")
    paged = Paged(root, empty_store, **getattr(request, "param", {}))
    yield paged
    paged.close()
