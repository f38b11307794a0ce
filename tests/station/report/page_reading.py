"""Reads a page as a browser would: its elements, in order, and the text of each."""

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"br", "hr", "img", "input", "meta"}


@dataclass
class Element:
    tag: str
    attributes: dict
    children: list = field(default_factory=list)

    @property
    def text(self):
        return "".join(c if isinstance(c, str) else c.text for c in self.children)

    def all(self, tag, class_=None):
        found = []
        for child in self.children:
            if isinstance(child, str):
                continue
            has_class = class_ is None or class_ in child.attributes.get("class", "").split()
            if child.tag == tag and has_class:
                found.append(child)
            found += child.all(tag, class_)
        return found


class _Reader(HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open = [Element("page", {})]

    def handle_starttag(self, tag, attrs):
        assert len(dict(attrs)) == len(attrs), f"an attribute of <{tag}> stands twice"
        element = Element(tag, dict(attrs))
        self.open[-1].children.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_endtag(self, tag):
        assert self.open[-1].tag == tag, f"</{tag}> closes <{self.open[-1].tag}>"
        self.open.pop()

    def handle_data(self, data):
        self.open[-1].children.append(data)


def read_page(text):
    """Return the page's root; an element that is not closed in its turn fails the test."""
    reader = _Reader()
    reader.feed(text)
    reader.close()
    assert [element.tag for element in reader.open] == ["page"], "elements left open"
    return reader.open[0]


def everything(element):
    yield element
    for child in element.children:
        if not isinstance(child, str):
            yield from everything(child)
