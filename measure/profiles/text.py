"""Wheel profiles as text of any known format; tables (CSV) themselves."""

import re
from collections.abc import Sequence

import numpy as np

from measure.errors import ProfileTextInvalid
from measure.profile import Profile
from measure.profiles.miniprof import MiniProfText, looks_like_miniprof, parse_miniprof
from measure.profiles.numbers import has_decimal_commas, numbers_of
from measure.profiles.orientation import Origin, oriented

_LATERAL = {
    "d": Origin.BACK,
    "x": Origin.UNSAID,
    "y": Origin.TAPE,
}
_UNIT = re.compile(r"_mm$|\s+mm$|\s*[\[(].*$")
_HEIGHTS = ("h", "z", "y")


def parse_profile_text(text: str) -> MiniProfText:
    """Read a profile from a text of any of the known formats; a table has no header.

    Raises
    ------
    ProfileTextInvalid
        If it is none of them, or holds no wheel.
    """
    if looks_like_miniprof(text):
        return parse_miniprof(text)
    return MiniProfText({}, parse_profile_csv(text))


def parse_profile_csv(text: str) -> Profile:
    """Read a profile from a table.

    Parameters
    ----------
    text
        Rows of two numbers or more, parted by comma, semicolon, tab or blanks; lines that start
        with # are skipped. A first line of names says what the columns are: ``d`` (from the
        flange back) or ``y`` (from the tape circle), then ``h`` or ``z``; without it, or by
        ``x,y``, the flange tip tells what the places count from.

    Raises
    ------
    ProfileTextInvalid
        If there are too few rows, or no flange above a tread in them.
    """
    lines = [line for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    lines = [line for line in lines if not line.lstrip().startswith("#")]
    if not lines:
        raise ProfileTextInvalid("no rows; a profile of d,h in mm is needed")
    named = not any(sign.isdigit() for sign in lines[0])
    body = lines[named:]
    commas = has_decimal_commas(body)
    rows = [numbers_of(line, decimal_commas=commas) for line in body]
    if any(row is None for row in rows):
        bad = next(i for i, row in enumerate(rows) if row is None) + 1 + named
        raise ProfileTextInvalid(f"row {bad} is not two numbers or more; allowed: d,h in mm")
    lateral, height, origin = _named_columns(lines[0]) if named else (0, 1, Origin.UNSAID)
    full = [row for row in rows if row is not None]
    if any(len(row) <= max(lateral, height) for row in full):
        raise ProfileTextInvalid("a row has too few numbers; d and h are needed in each")
    return oriented(np.array([[row[lateral], row[height]] for row in full]).reshape(-1, 2), origin)


def _named_columns(line: str) -> tuple[int, int, Origin]:
    separator = next((sign for sign in ";,\t" if sign in line), None)
    names = [_UNIT.sub("", part.strip().strip('"').lower()) for part in line.split(separator)]
    lateral = _first(names, _LATERAL)
    if lateral is None:
        raise ProfileTextInvalid(f"columns {names}: no d (from the back) or y (from the tape)")
    height = _first([name if i != lateral else "" for i, name in enumerate(names)], _HEIGHTS)
    if height is None:
        raise ProfileTextInvalid(f"columns {names}: no h or z, the height")
    return lateral, height, _LATERAL[names[lateral]]


def _first(names: Sequence[str], wanted: Sequence[str] | dict[str, Origin]) -> int | None:
    return next((i for i, name in enumerate(names) if name in wanted), None)
