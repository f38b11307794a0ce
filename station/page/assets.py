"""Styles and scripts, read once; their address changes with their content, so that they are kept.

All are below one digest of them all: a script that imports another by a relative address gets the
one that it was made with.
"""

import gzip
import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Final

_MEDIA_TYPES: Final = {
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
    "txt": "text/plain; charset=utf-8",
    "toml": "text/plain; charset=utf-8",
}
PAGES: Final = ("now", "passes", "calibration", "recordings", "set_up")
"""The folders of the pages; each has its own templates and static files."""


@dataclass(frozen=True, slots=True)
class Asset:
    """One file as it is sent."""

    media_type: str
    plain: bytes
    packed: bytes
    """The same by gzip."""


@dataclass(frozen=True, slots=True)
class Assets:
    """All files by their names, as ``now/live.js``."""

    files: Mapping[str, Asset]
    digest: str

    @classmethod
    def read(cls) -> "Assets":
        """Read the files of the shell and of each page."""
        root = files("station.page")
        found = dict(_below(root / "static", ""))
        for page in PAGES:
            found |= dict(_below(root / page / "static", f"{page}/"))
        joined = hashlib.sha256()
        for name in sorted(found):
            joined.update(f"{name}\n{len(found[name])}\n".encode() + found[name])
        return cls({name: _asset(name, found[name]) for name in found}, joined.hexdigest()[:16])

    def address(self, name: str) -> str:
        """Return where a file is had; KeyError where there is none of that name."""
        if name not in self.files:
            raise KeyError(f"no static file {name!r}")
        return f"/static/{self.digest}/{name}"


def _below(folder: Traversable, prefix: str) -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            yield from _below(entry, f"{prefix}{entry.name}/")
        elif entry.name.rpartition(".")[2] in _MEDIA_TYPES:
            yield f"{prefix}{entry.name}", entry.read_bytes()


def _asset(name: str, plain: bytes) -> Asset:
    # No time in it: the same file is the same bytes at every start.
    return Asset(_MEDIA_TYPES[name.rpartition(".")[2]], plain, gzip.compress(plain, 9, mtime=0))
