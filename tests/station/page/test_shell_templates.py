"""Shows what holds for every template: nothing inline that the strict policy would refuse, and no
word outside the texts.  What browsers make of the pages is shown by those of each page."""

import ast
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest
from jinja2 import Environment, nodes

import station.page
from station.page.texts import Texts

ROOT = Path(station.page.__file__).parent
TEMPLATES = sorted(ROOT.rglob("*.html"))
SOURCES = sorted(ROOT.rglob("*.py"))
TEXTS = Texts.of()
_GAP = "\N{WHITE SQUARE}"
"""In place of what a template fills in."""
_WORD = re.compile(r"[^\W\d_]{2,}")
_SAID = {"aria-label", "title", "placeholder", "alt", "summary", "label"}
_PART = re.compile(r"/|[a-z-]+=")
"""How an address or an attribute begins, which macros put into tags."""
_NOT_READ = {"style", "code"}
_EVALUATED = re.compile(r"^(on\w+|hx-on.*|hx-vars|hx-vals|style|srcdoc)$")


class Markup(HTMLParser):
    """What a template has in it by itself: faults of policy, and words."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.faults: list[str] = []
        self.words: list[str] = []
        self._within: list[str] = []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self._within.append(tag)
        self.faults += [f"<{tag} {name}>" for name in given if self._is_evaluated(name, given)]
        if tag == "script" and "src" not in given and given.get("type") != "application/json":
            self.faults.append("<script> without src")
        if tag == "style":
            self.faults.append("<style>")
        self.faults += [
            f"<{tag} {name}={value}>"
            for name, value in given.items()
            if name in {"src", "href", "action"}
            and re.match(r"(https?:)?//|javascript:", value or "")
        ]
        self.words += [
            given[name] for name in _SAID & given.keys() if _WORD.search(given[name] or "")
        ]

    @staticmethod
    def _is_evaluated(name, given):
        if name == "hx-vals":
            return (given[name] or "").startswith(("js:", "javascript:"))
        if name == "hx-trigger":
            return "[" in (given[name] or "")
        return bool(_EVALUATED.match(name))

    def handle_endtag(self, tag):
        if tag in self._within:
            while self._within.pop() != tag:
                pass

    def handle_data(self, data):
        text = data.strip()
        if _WORD.search(text) and not _PART.match(text) and not ({*self._within} & _NOT_READ):
            self.words.append(text)


def faults_of(text):
    """What a policy would refuse of a page as it is sent."""
    markup = Markup()
    markup.feed(text)
    return markup.faults


def tree_of(path):
    return Environment(autoescape=True).parse(path.read_text("utf-8"))  # noqa: S701  nothing is rendered


def markup_of(path):
    parts = []
    for output in tree_of(path).find_all(nodes.Output):
        for node in output.nodes:
            parts.append(node.data if isinstance(node, nodes.TemplateData) else _GAP)
    markup = Markup()
    markup.feed("".join(parts))
    markup.close()
    return markup


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: str(path.relative_to(ROOT)))
def test_a_template_has_nothing_inline_and_no_word_of_its_own(path):
    markup = markup_of(path)
    assert markup.faults == []
    assert markup.words == [], "put it into texts/en and show it by t()"


def test_the_walk_sees_what_it_is_to_find(tmp_path):
    bad = tmp_path / "bad.html"
    bad.write_text(
        '<p style="x" onclick="y" title="Say {{ a }}">Words {{ b }}</p><script>z</script>'
        '<a href="//elsewhere">{{ c }}</a><div hx-trigger="click[d]"></div>'
    )
    markup = markup_of(bad)
    assert len(markup.faults) == 5
    assert sorted(markup.words) == [f"Say {_GAP}", f"Words {_GAP}"]


def test_no_template_lets_markup_through():
    for path in TEMPLATES:
        tree = tree_of(path)
        filters = {node.name for node in tree.find_all(nodes.Filter)}
        assert "safe" not in filters, path
        assert not list(tree.find_all(nodes.ScopedEvalContextModifier)), path


def constants_of_template(path):
    """The texts that a template asks for: whole keys, and beginnings of them."""
    whole, begun = set(), set()
    for call in tree_of(path).find_all(nodes.Call):
        name = getattr(call.node, "name", None)
        for said in call.args[:1] if name in {"t", "texts_below"} else ():
            for found in _told(said):
                if name == "texts_below":
                    begun.add(f"{found}.")
                elif found.endswith(".") or not isinstance(said, nodes.Const | nodes.CondExpr):
                    begun.add(found)
                else:
                    whole.add(found)
    return whole, begun


def _told(node):
    """The beginnings of what an expression may be; none where it is not told by itself."""
    if isinstance(node, nodes.Const):
        return [str(node.value)]
    if isinstance(node, nodes.CondExpr):
        return [*_told(node.expr1), *(_told(node.expr2) if node.expr2 else [])]
    if isinstance(node, nodes.Concat | nodes.Add):
        return _told(node.nodes[0] if isinstance(node, nodes.Concat) else node.left)
    return []


def strings_of_sources():
    """Every text in the pages' own code and templates that might be a key, or begin one."""
    found = set()
    for path in SOURCES:
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.add(node.value)
    for path in TEMPLATES:
        found |= {str(node.value) for node in tree_of(path).find_all(nodes.Const)}
    return found


def test_every_text_that_a_template_asks_for_is_there():
    for path in TEMPLATES:
        whole, begun = constants_of_template(path)
        assert {key for key in whole if key not in TEXTS} == set(), path
        assert {one for one in begun if not any(key.startswith(one) for key in TEXTS)} == set(), (
            path
        )


def test_every_text_is_asked_for():
    strings = strings_of_sources()
    begun = {one for one in strings if re.fullmatch(r"[a-z_]+\.[a-z0-9_.]*[._]", one)}
    for path in TEMPLATES:
        begun |= constants_of_template(path)[1]
    begun |= {f"{one}." for one in strings if re.fullmatch(r"[a-z_]+(\.[a-z_]+)+", one)}
    titles = {f"{page}.title" for page in station.page.assets.PAGES}
    unused = {
        key
        for key in TEXTS
        if key not in strings | titles and not any(key.startswith(one) for one in begun)
    }
    assert unused == set()


def test_no_two_texts_have_one_key():
    import tomllib  # noqa: PLC0415  this test alone reads the files themselves

    def leaves(table):
        return sum(leaves(each) if isinstance(each, dict) else 1 for each in table.values())

    files = sorted((ROOT / "texts" / "en").glob("*.toml"))
    assert len(list(TEXTS)) == sum(leaves(tomllib.loads(file.read_text("utf-8"))) for file in files)
    for file in files:
        keys = re.findall(r'^"', file.read_text("utf-8"), flags=re.MULTILINE)
        assert keys == [], f"{file.name}: a key in quotes may hide another"
