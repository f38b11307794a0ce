"""Rows of numbers in texts from anywhere: separators, decimal points and decimal commas."""

import re
from collections.abc import Sequence

import numpy as np

_COMMENT = ("!", '"', "%", "#")
_DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
_BETWEEN_COLUMNS = re.compile(r"[;\t]|(?<=[\d.]) +(?=[-+\d.])")


def is_comment(line: str) -> bool:
    """Tell a line that is for people only."""
    return line.lstrip().startswith(_COMMENT)


def has_decimal_commas(lines: Sequence[str]) -> bool:
    """Tell whether commas are decimal points in rows of numbers.

    They are where no point is in any row, and something else parts the columns.
    """
    return not any("." in line for line in lines) and any(
        _DECIMAL_COMMA.search(line) and _BETWEEN_COLUMNS.search(line.strip()) for line in lines
    )


def numbers_of(line: str, *, decimal_commas: bool) -> list[float] | None:
    """Return the numbers of a row, or None where it is not two finite numbers or more."""
    text = line.replace(",", ".") if decimal_commas else line.replace(",", " ")
    values = [number(part) for part in text.replace(";", " ").split()]
    found = [value for value in values if value is not None]
    return found if len(found) == len(values) >= 2 else None


def number(text: str) -> float | None:
    """Return the finite number that a text is, with a decimal point or comma, or None."""
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        return None
    return value if np.isfinite(value) else None
