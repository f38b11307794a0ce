"""The rows of a points.csv, each checked: what a row may say, whichever program wrote it."""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass

from calib import Target
from station.errors import InputUnusable

NEEDED = ("image", "kind", "row", "col", "u", "v", "sigma_u", "sigma_v")
DOT_RADIUS = "dot_radius_pitches"
"""A column that may be missing, or empty: the centres of large dots seen at an angle need it."""

KINDS = ("dot", "stripe")

_DELIMITERS = ",;\t"
_LARGEST_PX = 1e5
"""No sensor is as large, and beyond it rounding begins to count."""
_LARGEST_DOT_RADIUS = 0.5  # pitches: larger ones would touch
_SIGMAS_PX = (1e-6, 1e4)


@dataclass(frozen=True, slots=True)
class PointRow:
    """One checked row of the file; a stripe point is at row and column -1.

    `dot_radius` is in pitches, None where the file tells none.
    """

    line: int
    image: str
    kind: str
    row: int
    col: int
    u: float
    v: float
    sigma_u: float
    sigma_v: float
    dot_radius: float | None = None


def point_rows(text: str, target: Target, *, name: str) -> Iterator[PointRow]:
    """Yield the rows of the text of points.csv, parted by commas, semicolons or tabs.

    Raises
    ------
    InputUnusable
        If a column is missing or stands twice, a row has more fields than the header, a number
        does not parse or is out of range, or a dot is off the target.
    """
    header = text.partition("\n")[0]
    delimiter = max(_DELIMITERS, key=header.count)
    reader = csv.DictReader(io.StringIO(text), delimiter=delimiter, skipinitialspace=True)
    columns = [column.strip() for column in reader.fieldnames or ()]
    _check_header(columns, name)
    reader.fieldnames = columns
    for line, fields in enumerate(reader, start=2):
        yield _checked(fields, line, target, name)


def _check_header(columns: list[str], name: str) -> None:
    allowed = f"allowed: a header with {','.join(NEEDED)}"
    missing = [column for column in NEEDED if column not in columns]
    if missing:
        raise InputUnusable(f"{name}: no column {', '.join(missing)}; {allowed}")
    twice = [column for column in (*NEEDED, DOT_RADIUS) if columns.count(column) > 1]
    if twice:
        raise InputUnusable(f"{name}: column {', '.join(twice)} stands twice; {allowed}, each once")


def _checked(fields: dict[str, str], line: int, target: Target, name: str) -> PointRow:
    def refuse(what: str) -> InputUnusable:
        return InputUnusable(f"{name} line {line}: {what}; correct the row or leave it out")

    if None in fields:
        raise refuse(
            "more fields than the header has columns; allowed: one field a column, decimal points"
        )
    if not fields["image"]:
        raise refuse("no name of an image")
    kind = fields["kind"]
    if kind not in KINDS:
        raise refuse(f"kind {kind!r}; allowed: {', '.join(KINDS)}")
    try:
        u, v, sigma_u, sigma_v = (_number(fields, c) for c in ("u", "v", "sigma_u", "sigma_v"))
        row, col = (_whole(fields, c) if kind == "dot" else -1 for c in ("row", "col"))
        radius = _number(fields, DOT_RADIUS) if kind == "dot" and fields.get(DOT_RADIUS) else None
    except ValueError as error:
        raise refuse(str(error)) from None
    if not all(map(math.isfinite, (u, v, sigma_u, sigma_v))):
        raise refuse("a coordinate or sigma that is not finite")
    if not max(abs(u), abs(v)) <= _LARGEST_PX:
        raise refuse(f"a point at {u:g}, {v:g}; allowed: coordinates up to {_LARGEST_PX:g} px")
    if wrong := _wrong_with_sigmas(kind, sigma_u, sigma_v):
        raise refuse(wrong)
    if kind == "dot" and not (0 <= row < target.rows and 0 <= col < target.cols):
        raise refuse(f"dot at row {row}, col {col}; allowed on {target}: rows 0 to "
                     f"{target.rows - 1}, cols 0 to {target.cols - 1}")  # fmt: skip
    if radius is not None and not 0.0 < radius < _LARGEST_DOT_RADIUS:
        raise refuse(f"{DOT_RADIUS} {radius:g}; allowed: between 0 and {_LARGEST_DOT_RADIUS:g}")
    return PointRow(line, fields["image"], kind, row, col, u, v, sigma_u, sigma_v, radius)


def _wrong_with_sigmas(kind: str, sigma_u: float, sigma_v: float) -> str:
    """Return what is wrong with a point's sigmas, empty if nothing; px."""
    low, high = sorted((sigma_u, sigma_v))
    # Along u or v nothing may be known of a stripe that runs so: its sigma is then 0 there (Eq. 9).
    least = low if kind == "dot" else high
    if low >= 0.0 and _SIGMAS_PX[0] <= least and high <= _SIGMAS_PX[1]:
        return ""
    return (
        f"sigma {sigma_u:g}, {sigma_v:g}; allowed: positive, {_SIGMAS_PX[0]:g} to "
        f"{_SIGMAS_PX[1]:g} px"
    )


def _number(fields: dict[str, str], column: str) -> float:
    try:
        return float(fields[column])
    except (ValueError, TypeError):
        raise ValueError(f"{column} {fields[column]!r} is not a number") from None


def _whole(fields: dict[str, str], column: str) -> int:
    """Read a whole number, also where a spreadsheet wrote it as 3.0."""
    number = _number(fields, column)
    if not number.is_integer():
        raise ValueError(f"{column} {fields[column]!r} is not a whole number")
    return int(number)
