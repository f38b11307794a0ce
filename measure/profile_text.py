"""Wheel profiles as text: MiniProf files of both ages, and tables (CSV)."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from calib import FloatArray
from measure.errors import ProfileTextInvalid
from measure.profile import Profile
from measure.quantities import Quantity

_OLD_MARKS = ("MINIPROF", "#MINIWHEELPROF")
_MIN_ROWS = 20
_CLAIMS = {
    "Sh": Quantity.FLANGE_HEIGHT,
    "Sd": Quantity.FLANGE_THICKNESS_10,
    "qR": Quantity.FLANGE_GRADIENT_QR,
}
_TAPE_D_MM = 70.0
_FLANGE_D_MM = (8.0, 22.0)
_MIN_FLANGE_MM = 14.0
_TABLE_COLUMNS = {"d": 0.0, "d_mm": 0.0, "x": 0.0, "y": _TAPE_D_MM, "y_mm": _TAPE_D_MM}
_TABLE_HEIGHTS = ("h", "h_mm", "z", "z_mm", "y", "y_mm")


@dataclass(frozen=True, slots=True, eq=False)
class MiniProfText:
    """What a MiniProf file says.

    Attributes
    ----------
    header
        Its ``Key=Value`` lines; empty for the old format.
    profile
        Its points, from the flange back, height upwards.
    """

    header: Mapping[str, str]
    profile: Profile

    @property
    def claimed(self) -> dict[Quantity, float]:
        """The readings its header states.

        Files of the old format state figures too, but those are a template's, left standing.
        """
        return {
            quantity: float(self.header[key])
            for key, quantity in _CLAIMS.items()
            if _is_number(self.header.get(key, ""))
        }


def parse_profile_text(text: str) -> Profile:
    """Read a profile from a text of any of the known formats.

    Raises
    ------
    ProfileTextInvalid
        If it is none of them, or holds no wheel.
    """
    return parse_miniprof(text).profile if looks_like_miniprof(text) else parse_profile_csv(text)


def looks_like_miniprof(text: str) -> bool:
    """Tell a MiniProf file from a table."""
    first = text.lstrip("\ufeff \r\n").split("\n", 1)[0].upper()
    return first.startswith(_OLD_MARKS) or ("=" in first and not first.startswith("#"))


def parse_miniprof(text: str) -> MiniProfText:
    """Read a MiniProf file.

    Parameters
    ----------
    text
        ``Key=Value`` lines (or the old format's free lines), a blank line, rows of X Y in mm;
        X from the flange back, either order of rows, either sign of Y.

    Raises
    ------
    ProfileTextInvalid
        If there are too few rows, fewer or more than ``XYPoints`` says, or no flange above a
        tread in them.

    Examples
    --------
    >>> parse_miniprof("Sd=32.5")
    Traceback (most recent call last):
        ...
    measure.errors.ProfileTextInvalid: no rows of X Y after the header; 20 or more are needed
    """
    lines = text.lstrip("\ufeff").splitlines()
    blank = next((i for i, line in enumerate(lines) if not line.strip()), len(lines))
    header = dict(_key_value(line) for line in lines[:blank] if "=" in line)
    rows = [numbers for line in lines[blank:] if (numbers := _numbers(line)) is not None]
    if not rows:
        raise ProfileTextInvalid("no rows of X Y after the header; 20 or more are needed")
    promised = header.get("XYPoints", "")
    if promised.isdigit() and int(promised) != len(rows):
        raise ProfileTextInvalid(
            f"XYPoints={promised} but {len(rows)} rows of numbers; the file is cut or damaged"
        )
    columns = [name.strip().upper() for name in header.get("ColumnDef", "X,Y").split(",")]
    if not {"X", "Y"} <= set(columns):
        raise ProfileTextInvalid(f"ColumnDef={header['ColumnDef']} names no X and Y")
    table = _table(rows, columns.index("X"), columns.index("Y"))
    return MiniProfText(MappingProxyType(header), _profile(table))


def format_miniprof(profile: Profile, header: Mapping[str, str] | None = None) -> str:
    """Write a profile as a MiniProf file.

    Parameters
    ----------
    profile
        What to write.
    header
        ``Key=Value`` lines to put first (``Sd``, ``Sh``, ``qR``, ``Date``, ``WheelID`` and so
        on). ColumnDef and XYPoints are added.

    Raises
    ------
    ProfileTextInvalid
        If a key or value would break the format.
    """
    fields = {**(header or {}), "ColumnDef": "X,Y", "XYPoints": str(len(profile))}
    for key, value in fields.items():
        if not key or "=" in key or any(sign in key + value for sign in "\r\n"):
            raise ProfileTextInvalid(f"header line {key!r}={value!r} must be one line with one =")
    head = [f"{key}={value}" for key, value in fields.items()]
    rows = [f"{d:.4f} {h:.4f}" for d, h in profile.points_mm]
    return "\n".join([*head, "", *rows]) + "\n"


def parse_profile_csv(text: str) -> Profile:
    """Read a profile from a table.

    Parameters
    ----------
    text
        Rows of two numbers or more, parted by comma, semicolon, tab or blanks; lines that start
        with # are skipped. A first line of names says what the columns are: ``d`` (from the
        flange back) or ``y`` (from the tape circle), then ``h`` or ``z``; without it they are
        told by their range.

    Raises
    ------
    ProfileTextInvalid
        If there are too few rows, or no flange above a tread in them.
    """
    lines = [line for line in text.lstrip("\ufeff").splitlines() if line.strip()]
    lines = [line for line in lines if not line.lstrip().startswith("#")]
    if not lines:
        raise ProfileTextInvalid("no rows; a profile of d,h in mm is needed")
    names = [part.strip().lower() for part in _parts(lines[0])]
    named = _numbers(lines[0]) is None
    rows = [_numbers(line) for line in lines[named:]]
    if any(row is None for row in rows):
        bad = next(i for i, row in enumerate(rows) if row is None) + 1 + named
        raise ProfileTextInvalid(f"row {bad} is not two numbers or more; allowed: d,h in mm")
    lateral, height, shift = _named_columns(names) if named else (0, 1, None)
    table = _table([row for row in rows if row is not None], lateral, height)
    if shift is None:
        # Around the tape circle, -70 to 60, or from the flange back, 0 to 130 and more.
        shift = _TAPE_D_MM if -80.0 < table[:, 0].min() < -50.0 else 0.0
    return _profile(table + [shift, 0.0])


def _named_columns(names: list[str]) -> tuple[int, int, float]:
    lateral = next((i for i, name in enumerate(names) if name in _TABLE_COLUMNS), None)
    if lateral is None:
        raise ProfileTextInvalid(f"columns {names}: no d (from the back) or y (from the tape)")
    heights = (i for i, n in enumerate(names) if n in _TABLE_HEIGHTS and i != lateral)
    height = next(heights, None)
    if height is None:
        raise ProfileTextInvalid(f"columns {names}: no h or z, the height")
    return lateral, height, _TABLE_COLUMNS[names[lateral]]


def _table(rows: list[list[float]], first: int, second: int) -> FloatArray:
    if min(len(row) for row in rows) <= max(first, second):
        raise ProfileTextInvalid("a row has too few numbers; X and Y are needed in each")
    return np.array([[row[first], row[second]] for row in rows])


def _profile(table_mm: FloatArray) -> Profile:
    """Turn rows of (lateral, height) so that the flange is first and up."""
    if len(table_mm) < _MIN_ROWS:
        raise ProfileTextInvalid(f"{len(table_mm)} rows; {_MIN_ROWS} or more are needed")
    d, h = table_mm.T
    if d.max() < 30.0 and d.min() < -_TAPE_D_MM:  # A right-hand file: X runs the other way.
        d = -d
    if d[0] > d[-1]:
        d, h = d[::-1], h[::-1]
    on_flange = (d > _FLANGE_D_MM[0]) & (d < _FLANGE_D_MM[1])
    if not (on_flange.sum() >= 5 and d.max() > _TAPE_D_MM and d.min() > -30.0):
        raise ProfileTextInvalid(
            f"lateral places {d.min():.1f} to {d.max():.1f} mm; a wheel runs from its flange "
            f"back at 0 to beyond {_TAPE_D_MM:.0f}"
        )
    # The top of the flange tells which way is up; the back face reaches either way.
    rise = float(np.median(h[on_flange]) - h[np.argmin(np.abs(d - _TAPE_D_MM))])
    if not abs(rise) >= _MIN_FLANGE_MM:
        raise ProfileTextInvalid(
            f"no flange: {abs(rise):.1f} mm from the tread at {_TAPE_D_MM:.0f}; "
            f"{_MIN_FLANGE_MM:.0f} or more are needed"
        )
    return Profile(d, np.sign(rise) * h, np.zeros(len(d)))


def _key_value(line: str) -> tuple[str, str]:
    key, _, value = line.partition("=")
    return key.strip(), value.strip()


def _parts(line: str) -> list[str]:
    if ";" in line:
        return line.split(";")
    return line.replace(",", " ").split()


def _numbers(line: str) -> list[float] | None:
    """Return the numbers of a row, or None where it is not two numbers or more."""
    # Where semicolons part the columns, a comma is a decimal point.
    parts = [part.strip() for part in _parts(line)]
    if ";" in line:
        parts = [part.replace(",", ".") for part in parts]
    if len(parts) < 2 or not all(_is_number(part) for part in parts):
        return None
    return [float(part) for part in parts]


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
