"""Parts that several pages have: tables that can be scrolled by keys, cells, badges."""

from collections.abc import Iterable

from measure import Alarm, Quantity, Side
from station.report import Child, Markup, element, minus

UNKNOWN = "–"
NAMES = {
    Quantity.FLANGE_HEIGHT: "Flange height Sh",
    Quantity.FLANGE_THICKNESS_10: "Flange thickness Sd",
    Quantity.FLANGE_THICKNESS_12: "Flange thickness at +12 mm",
    Quantity.FLANGE_GRADIENT_QR: "Flange gradient qR",
    Quantity.TREAD_WEAR: "Tread wear (from the tip)",
    Quantity.TREAD_WEAR_AT_70: "Tread wear at the tape circle",
    Quantity.TREAD_WEAR_MAX: "Greatest tread wear",
    Quantity.HOLLOW_DEPTH: "Hollow",
    Quantity.DIAMETER: "Diameter",
}
"""As a station's page calls them."""
SIDES = {Side.LEFT: "left wheel", Side.RIGHT: "right wheel"}
_BADGES = {Alarm.ALARM: ("bad", "alarm"), Alarm.WARNING: ("warn", "warning")}


def table(caption: str, heads: Iterable[str], rows: Iterable[Iterable[Child]]) -> Markup:
    """Return a table under its caption; the first cell of a row names it.

    Who has no mouse reaches it by the tabulator and scrolls it by the arrows.
    """
    head = element("tr", (element("th", each, scope="col") for each in heads))
    whole = element(
        "table",
        element("caption", caption, class_="hidden-text"),
        element("thead", head),
        element("tbody", (_row(row) for row in rows)),
    )
    return element("div", whole, class_="wide", tabindex="0", role="region", aria_label=caption)


def _row(cells: Iterable[Child]) -> Markup:
    first, *others = cells
    return element("tr", element("th", first, scope="row"), (_cell(each) for each in others))


def _cell(child: Child) -> Markup:
    if isinstance(child, Markup) and child.startswith("<td"):
        return child
    return element("td", child)


def nowrap(text: str) -> Markup:
    """Return a cell whose text stays in one line: a moment, a figure with its unit."""
    return element("td", text, class_="nowrap")


def two_lines(text: str, below: str) -> Markup:
    """Return a cell of two lines, the second of less weight."""
    if below == UNKNOWN:
        return nowrap(text)
    return element("td", text, element("span", below, class_="below"), class_="nowrap")


def badge(text: str, kind: str) -> Markup:
    """Return a word that is seen from afar: good, warn or bad."""
    return element("span", text, class_=f"badge {kind}")


def alarm_badge(alarm: Alarm) -> Child:
    """Return what a value means against the limits, where it means something."""
    return badge(_BADGES[alarm][1], _BADGES[alarm][0]) if alarm in _BADGES else UNKNOWN


def card(title: str, *children: Child, id_: str | None = None) -> Markup:
    """Return a part of a page under its title."""
    return element("section", element("h2", title), children, class_="card", id=id_)


def empty(text: str) -> Markup:
    """Return that there is nothing to show, in a line."""
    return element("p", text, class_="empty")


def mm(value: float | None, digits: int = 2, *, signed: bool = False) -> str:
    """Return a length with its unit.

    >>> mm(-0.5), mm(0.0123, 3, signed=True), mm(None)
    ('\u22120.50\u202fmm', '+0.012\u202fmm', '\u2013')
    """
    if value is None:
        return UNKNOWN
    return minus(f"{value:{'+' if signed else ''}.{digits}f}") + "\N{NARROW NO-BREAK SPACE}mm"
