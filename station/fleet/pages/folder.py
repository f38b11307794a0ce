"""The folder that the pages lie in: each whole at every moment, written only where it changed."""

from dataclasses import dataclass, field
from pathlib import Path

from station.documents import write_whole
from station.errors import InputUnusable
from station.fleet.pages.addresses import MADE, OVERVIEW
from station.fleet.pages.frame import GENERATOR

_FOLDERS = ("wheels", "names")
_HEAD_CHARACTERS = 2000


@dataclass(slots=True)
class PagesFolder:
    """A folder of pages, while they are written.

    Attributes
    ----------
    written
        How many were new or changed.
    kept
        Addresses of all that were given, changed or not.
    """

    root: Path
    written: int = 0
    kept: set[str] = field(default_factory=set)

    @classmethod
    def prepared(cls, root: Path) -> "PagesFolder":
        """Make a folder ready for pages.

        Raises
        ------
        InputUnusable
            If it cannot be made, or holds something else: pages that are there no longer are
            removed, and nobody else's file must be near.
        """
        try:
            if root.is_dir() and any(root.iterdir()) and not _is_ours(root):
                raise InputUnusable(
                    f"{root} holds something else than pages of a fleet; give an empty folder, or "
                    "one that does not exist"
                )
            for name in _FOLDERS:
                (root / name).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputUnusable(
                f"{root}: no folder can be made there ({error.strerror}); give one you may write"
            ) from error
        return cls(root)

    def put(self, address: str, text: str) -> None:
        """Write a page, unless it is there as it is.

        Raises
        ------
        InputUnusable
            If it cannot be written.
        """
        self.kept.add(address)
        content = text.encode("utf-8", "replace")
        path = self.root / address
        if not path.is_file() or path.read_bytes() != content:
            write_whole(path, content)
            self.written += 1

    def remove_others(self) -> int:
        """Remove the pages of wheels that the fleet knows no longer; return how many were."""
        removed = 0
        for name in _FOLDERS:
            for path in (self.root / name).iterdir():
                address = f"{name}/{path.name}"
                if address not in self.kept and MADE.fullmatch(address):
                    path.unlink(missing_ok=True)
                    removed += 1
        return removed

    def overview(self) -> str | None:
        """Return the overview that was written last; None where there is none."""
        path = self.root / OVERVIEW
        return path.read_text("utf-8") if path.is_file() else None


def _is_ours(root: Path) -> bool:
    path = root / OVERVIEW
    if path.is_file():
        with path.open(encoding="utf-8", errors="replace") as stream:
            return GENERATOR in stream.read(_HEAD_CHARACTERS)
    # A first run that was killed: the overview comes last.
    return {each.name for each in root.iterdir()} <= set(_FOLDERS)
