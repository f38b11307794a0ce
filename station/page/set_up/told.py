"""Settings as people read them: a value with its unit, and the name it has in the file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pydantic import BaseModel

from station.page.formats import NARROW_SPACE

_UNITS: Final = {
    "us": "µs",
    "ns": "ns",
    "db": "dB",
    "hz": "Hz",
    "px": "px",
    "mm": "mm",
    "rad": "rad",
    "s": "s",
    "h": "h",
    "days": "d",
    "mb": "MB",
    "gb": "GB",
}
_OTHER_UNITS: Final = {"packet_size": "B", "drift_mm": "mm", "back_to_back": "mm"}


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting in force.

    Attributes
    ----------
    name
        In its table, as ``exposure_us``; the texts explain it by this.
    place
        In the file, as ``sensors.left.exposure_us``.
    value
        As it is shown; None where nothing is set.
    named
        Whether the texts explain it; what only cameras know bears the cameras' own name.
    """

    name: str
    place: str
    value: str | None
    named: bool = True


def settings_in(
    section: BaseModel, place: str, *, but: frozenset[str] = frozenset()
) -> list[Setting]:
    """Return the plain settings of a section in their order; tables within it are left out."""
    return [
        Setting(name, f"{place}.{name}", told(name, value))
        for name, value in section
        if name not in but and not isinstance(value, BaseModel | Mapping)
    ]


def told(name: str, value: object) -> str | None:
    """Return a value with the unit that its name ends in; None where there is no value.

    >>> told("exposure_us", 20000.0), told("days", ("mon", "tue")), told("gain_db", None)
    ('20000\u202fµs', 'mon, tue', None)
    """
    if value is None:
        return None
    if isinstance(value, tuple | list):
        return ", ".join(filter(None, (told("", each) for each in value))) + _unit(name, value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.6g}{_unit(name, value)}"
    if isinstance(value, int):
        return f"{value}{_unit(name, value)}"
    return value.name if isinstance(value, Path) else str(value)


def _unit(name: str, value: object) -> str:
    if isinstance(value, tuple | list) and not any(isinstance(each, float) for each in value):
        return ""
    unit = _OTHER_UNITS.get(name) or _UNITS.get(name.rpartition("_")[2])
    # A rotation vector is in radians whatever its name says.
    if name == "rotation_vector":
        unit = "rad"
    return "" if unit is None else f"{NARROW_SPACE}{unit}"
