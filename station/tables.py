"""A bench's figures: rows of named values, printed as a table or as data."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Value = str | int | float | bool


@dataclass(frozen=True, slots=True)
class Table:
    """Figures of one bench.

    Attributes
    ----------
    title
        What was measured, with units.
    rows
        One mapping a row; all have the same keys, the columns.
    notes
        What the reader needs to judge the figures.
    """

    title: str
    rows: Sequence[Mapping[str, Value]]
    notes: Sequence[str] = ()

    def as_data(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        return {"title": self.title, "rows": [dict(r) for r in self.rows], "notes": [*self.notes]}

    def as_markdown(self) -> str:
        """Return the table as people read it and the README keeps it."""
        columns = list(self.rows[0]) if self.rows else []
        cells = [[_shown(row[column]) for column in columns] for row in self.rows]
        widths = [max(map(len, column)) for column in zip(columns, *cells, strict=True)]
        lines = [_line(columns, widths), _line(["-" * width for width in widths], widths)]
        lines += [_line(row, widths) for row in cells]
        return "\n".join([self.title, "", *lines, *(f"\n{note}" for note in self.notes)])


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = (cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
    return f"| {' | '.join(padded)} |"


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
