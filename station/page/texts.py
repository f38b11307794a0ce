"""The words of the pages: all in `texts/LANGUAGE`, a file a page, so that they can be translated.

A key is the file, the table and the name, as ``now.sensor.armed``; ``{name}`` in a text is filled.
"""

import tomllib
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any, Final

LANGUAGE: Final = "en"


class Texts:
    """The texts of one language."""

    def __init__(self, texts: Mapping[str, str]) -> None:
        self._texts = dict(texts)

    @classmethod
    def of(cls, language: str = LANGUAGE) -> "Texts":
        """Read the texts of a language."""
        found: dict[str, str] = {}
        for entry in (files("station.page") / "texts" / language).iterdir():
            page = entry.name.removesuffix(".toml")
            found |= _flat(tomllib.loads(entry.read_text("utf-8")), page)
        return cls(found)

    def say(self, key: str, /, **values: object) -> str:
        """Return a text with its gaps filled; KeyError where there is none of that key."""
        text = self._texts[key]
        return text.format(**values) if values else text

    def below(self, prefix: str) -> dict[str, str]:
        """Return the texts whose keys begin so, by the rest of the key: those a script needs."""
        start = f"{prefix}."
        return {
            key.removeprefix(start): text
            for key, text in self._texts.items()
            if key.startswith(start)
        }

    def __contains__(self, key: str) -> bool:
        return key in self._texts

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)


def _flat(table: Mapping[str, Any], prefix: str) -> dict[str, str]:
    """Return the texts of nested tables by their whole keys.

    >>> _flat({"title": "Now", "sensor": {"armed": "Armed"}}, "now")
    {'now.title': 'Now', 'now.sensor.armed': 'Armed'}
    """
    found: dict[str, str] = {}
    for name, value in table.items():
        key = f"{prefix}.{name}"
        found |= _flat(value, key) if isinstance(value, dict) else {key: str(value)}
    return found
