"""HTML and SVG as text that is escaped by construction.

A plain str that becomes a child or an attribute is escaped; only what `element` returned is not.
"""

from collections.abc import Iterable
from html import escape

_VOID = frozenset({"br", "hr", "img", "input", "meta"})


class Markup(str):
    """Text that is markup already."""

    __slots__ = ()


Child = str | Markup | Iterable["Child"]
Attribute = str | float | None


def element(name: str, /, *children: Child, **attributes: Attribute) -> Markup:
    """Return an element.

    In names of attributes a trailing underscore is dropped and others become hyphens
    (``class_``, ``stroke_width``); a capital as in ``viewBox`` stays. An attribute that is None
    is left out.

    Examples
    --------
    >>> element("td", "<script>", class_="num")
    '<td class="num">&lt;script&gt;</td>'
    >>> element("p", element("b", "a"), " & b")
    '<p><b>a</b> &amp; b</p>'
    """
    opening = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(_shown(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    if name in _VOID:
        return Markup(f"<{name}{opening}>")
    return Markup(f"<{name}{opening}>{join(children)}</{name}>")


def join(children: Iterable[Child]) -> Markup:
    """Return children one after the other; plain text among them is escaped."""
    return Markup("".join(_rendered(child) for child in children))


def _rendered(child: Child) -> str:
    if isinstance(child, Markup):
        return child
    return escape(child) if isinstance(child, str) else join(child)


def _shown(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def table(
    heads: Iterable[Child],
    rows: Iterable[Iterable[Child]],
    *,
    caption: str | None = None,
    class_: str | None = None,
) -> Markup:
    """Return a table; a cell that is an element ``td`` or ``th`` already is taken as it is."""
    head = element("tr", (element("th", each, scope="col") for each in heads))
    body = (element("tr", (_cell(each) for each in row)) for row in rows)
    whole = element(
        "table",
        element("caption", caption) if caption else (),
        element("thead", head),
        element("tbody", body),
        class_=class_,
    )
    return element("div", whole, class_="wide")


def _cell(child: Child) -> Markup:
    if isinstance(child, Markup) and child.startswith(("<td", "<th")):
        return child
    return element("td", child)


def number(text: str) -> Markup:
    """Return a table cell with a number, aligned as numbers are."""
    return element("td", text, class_="num")


def section(title: str, *children: Child) -> Markup:
    """Return a section of the page under its title."""
    return element("section", element("h2", title), children)


def figure(drawing: Markup, caption: Child) -> Markup:
    """Return a drawing with the words that say what is shown."""
    return element("figure", drawing, element("figcaption", caption))
