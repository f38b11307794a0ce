"""A page as a file: everything it needs is in it, and a browser is told to load and run nothing."""

from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files

from station.report import Child, Markup, element, join

GENERATOR = "treadline fleet"
_NOTICE = Markup("<!-- notice -->"), Markup("<!-- /notice -->")
_MENU = (
    ("index.html#stations", "Stations"),
    ("index.html#sensors", "Sensors"),
    ("index.html#wheels", "Wheels"),
    ("index.html#find", "Find a wheelset"),
)


def page(title: str, *main: Child, up: str = "", notice: str | None = None) -> str:
    """Return a page of the fleet.

    Parameters
    ----------
    up
        The way from the page's folder to that of the overview, as "../".
    notice
        What everybody has to read first.
    """
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=_policy()),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("meta", name="referrer", content="no-referrer"),
        element("meta", name="generator", content=GENERATOR),
        element("title", f"{title} · Fleet"),
        element("style", _style()),
    )
    links = (element("a", text, href=f"{up}{target}") for target, text in _MENU)
    top = element(
        "header",
        element("a", "Fleet", class_="fleet", href=f"{up}index.html"),
        element("nav", links, aria_label="Parts of the overview"),
        class_="top",
    )
    body = element(
        "body",
        element("a", "Skip to the content", class_="skip", href="#main"),
        top,
        element("main", _noticed(notice), main, id="main", tabindex="-1"),
    )
    return join([Markup("<!doctype html>\n"), element("html", head, body, lang="en")]) + "\n"


def with_notice(page_text: str, notice: str) -> str:
    """Return a page that was made earlier with another notice in place of its own."""
    begins, ends = _NOTICE
    before, _, rest = page_text.partition(begins)
    _, _, after = rest.partition(ends)
    return f"{before}{_noticed(notice)}{after}"


def _noticed(notice: str | None) -> Markup:
    begins, ends = _NOTICE
    said = element("p", notice, class_="refused", role="status") if notice else ()
    return join([begins, said, ends])


@cache
def _style() -> Markup:
    # Our own files, not input: the one text besides elements that is not escaped.
    own = files("station.fleet.pages").joinpath("fleet.css").read_text("utf-8")
    of_station = files("station").joinpath("page", "static", "page.css").read_text("utf-8")
    return Markup(of_station + own)


@cache
def _policy() -> str:
    """Return what a browser may do with a page: apply the style that is in it, and no more."""
    digest = b64encode(sha256(_style().encode()).digest()).decode()
    return f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
