"""MiniProf files of both ages, read and written."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from calib import FloatArray
from measure.errors import ProfileTextInvalid
from measure.gauging.levels import GaugeLevels
from measure.profile import Profile
from measure.profiles.numbers import has_decimal_commas, is_comment, number, numbers_of
from measure.profiles.orientation import oriented
from measure.quantities import Quantity

_OLD_MARKS = ("MINIPROF", "#MINIWHEELPROF")
_ROWS_IN_A_RUN = 5
_INCH_MM = 25.4
_INCHES = ("in", "inch", "inches", '"', "imperial")
_OTHER_LENGTHS = ("cm", "m", "um", "ft")
_CLAIMS = {
    "sh": Quantity.FLANGE_HEIGHT,
    "sd": Quantity.FLANGE_THICKNESS_10,
    "qr": Quantity.FLANGE_GRADIENT_QR,
}
# The old format states its figures without keys, and their names behind them or a line below.
_OLD_FIGURES = re.compile(
    r"([-\d.,]+)[ \t]+([-\d.,]+)[ \t]+([-\d.,]+)\s*\(?\s*sd\s*/\s*sh\s*/\s*qr", re.IGNORECASE
)
_OLD_ORDER = ("Sd", "Sh", "qR")


@dataclass(frozen=True, slots=True, eq=False)
class MiniProfText:
    """What a MiniProf file says.

    Attributes
    ----------
    header
        Its ``Key=Value`` lines; of the old format its Sd, Sh and qR.
    profile
        Its points, from the flange back, height upwards, mm.
    claimed
        The readings its header states, mm.
    levels
        Where its header says the gauges touch: L1 below the tip, L2 the tape circle, L3 above it.
    """

    header: Mapping[str, str]
    profile: Profile
    claimed: Mapping[Quantity, float] = field(default_factory=dict)
    levels: GaugeLevels = GaugeLevels()


def looks_like_miniprof(text: str) -> bool:
    """Tell a MiniProf file from a table."""
    first = text.lstrip("\ufeff \r\n").split("\n", 1)[0].upper()
    return first.startswith(_OLD_MARKS) or ("=" in first and not first.startswith("#"))


def parse_miniprof(text: str) -> MiniProfText:
    """Read a MiniProf file.

    Parameters
    ----------
    text
        ``Key=Value`` lines, keys in any case (or the old format's free lines), then rows of
        numbers, in the columns that ``ColumnDef`` names (X and Y where it does not); X from the
        flange back or the tape circle, towards the field side or away from it; Y up or down;
        rows in any order; decimal points or commas; in mm, or in inches where a key of units
        says so.

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
    head, body = _parted(text.lstrip("\ufeff").splitlines())
    header = dict(_key_value(line) for line in head if "=" in line) or _old_figures(head)
    by_key = {key.lower(): value for key, value in header.items()}
    scale_mm = _unit_mm(by_key)
    table = _table(body, by_key) * scale_mm
    claimed = {
        quantity: value * scale_mm
        for key, quantity in _CLAIMS.items()
        if (value := number(by_key.get(key, ""))) is not None
    }
    return MiniProfText(
        header=MappingProxyType(header),
        profile=oriented(table),
        claimed=MappingProxyType(claimed),
        levels=_levels(by_key, scale_mm),
    )


def format_miniprof(profile: Profile, header: Mapping[str, str] | None = None) -> str:
    """Write a profile as a MiniProf file, in ASCII.

    Parameters
    ----------
    profile
        What to write.
    header
        ``Key=Value`` lines to put first (``Sd``, ``Sh``, ``qR``, ``Date``, ``WheelID`` and so
        on). Units, ColumnDef and XYPoints are added.

    Raises
    ------
    ProfileTextInvalid
        If a key or value would break the format.
    """
    ours = {"Units": "mm", "ColumnDef": "X,Y", "XYPoints": str(len(profile))}
    fields = {**(header or {}), **ours}
    for key, value in fields.items():
        if not key or "=" in key or any(sign in key + value for sign in "\r\n"):
            raise ProfileTextInvalid(f"header line {key!r}={value!r} must be one line with one =")
        if not (key + value).isascii():
            raise ProfileTextInvalid(f"header line {key!r}={value!r} must be ASCII")
    head = [f"{key}={value}" for key, value in fields.items()]
    rows = [f"{d:.4f} {h:.4f}" for d, h in profile.points_mm]
    return "\n".join([*head, "", *rows]) + "\n"


def _parted(lines: Sequence[str]) -> tuple[list[str], list[str]]:
    """Part header and rows: where rows of numbers follow each other, the header has ended."""
    full = [line for line in lines if line.strip()]
    said = [i for i, line in enumerate(full) if not is_comment(line)]
    is_row = [numbers_of(full[i], decimal_commas=False) is not None for i in said]
    runs = (i for at, i in enumerate(said) if all(is_row[at : at + _ROWS_IN_A_RUN]))
    start = next(runs, len(full))
    return full[:start], full[start:]


def _key_value(line: str) -> tuple[str, str]:
    key, _, value = line.partition("=")
    return key.strip(), value.strip()


def _old_figures(head: Sequence[str]) -> dict[str, str]:
    found = _OLD_FIGURES.search("\n".join(head))
    return dict(zip(_OLD_ORDER, found.groups(), strict=True)) if found else {}


def _unit_mm(by_key: Mapping[str, str]) -> float:
    # A train is a unit too: what is no length is none of ours.
    for key, value in by_key.items():
        word = value.lower().strip(" .()[]")
        if "unit" in key and word in _INCHES:
            return _INCH_MM
        if "unit" in key and word in _OTHER_LENGTHS:
            raise ProfileTextInvalid(f"header {key}={value}; mm and inch can be read")
    return 1.0


def _table(body: Sequence[str], by_key: Mapping[str, str]) -> FloatArray:
    lines = [line for line in body if not is_comment(line)]
    commas = has_decimal_commas(lines)
    rows = [row for line in lines if (row := numbers_of(line, decimal_commas=commas)) is not None]
    if not rows:
        raise ProfileTextInvalid("no rows of X Y after the header; 20 or more are needed")
    promised = by_key.get("xypoints", "")
    if promised.isdigit() and int(promised) != len(rows):
        raise ProfileTextInvalid(
            f"XYPoints={promised} but {len(rows)} rows of numbers; the file is cut or damaged"
        )
    first, second = _columns(by_key.get("columndef", "X,Y"))
    if min(len(row) for row in rows) <= max(first, second):
        raise ProfileTextInvalid("a row has too few numbers; X and Y are needed in each")
    return np.array([[row[first], row[second]] for row in rows])


def _columns(definition: str) -> tuple[int, int]:
    names = [name.upper() for name in re.split(r"[\s,;]+", definition.strip()) if name]
    if not {"X", "Y"} <= set(names):
        raise ProfileTextInvalid(f"ColumnDef={definition} names no X and Y")
    return names.index("X"), names.index("Y")


def _levels(by_key: Mapping[str, str], scale_mm: float) -> GaugeLevels:
    def stated(key: str, otherwise_mm: float) -> float:
        value = number(by_key.get(key, ""))
        # Instruments write 0 for a level that is not set.
        return value * scale_mm if value else otherwise_mm

    usual = GaugeLevels()
    try:
        return GaugeLevels(
            tape_d_mm=stated("l2", usual.tape_d_mm),
            face_mm=stated("l3", usual.face_mm),
            below_tip_mm=stated("l1", usual.below_tip_mm),
        )
    except ValueError as error:
        raise ProfileTextInvalid(f"header L1, L2, L3: {error}") from error


def ascii_fields(fields: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Return fields as a header of ours can carry them: ASCII, one line, a stranger sign as ?."""
    return {
        key: " ".join(value.encode("ascii", "replace").decode().split()) for key, value in fields
    }
