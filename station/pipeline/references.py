"""Wheel profiles from files, and the reference that a name or a file stands for."""

from pathlib import Path

from measure import MeasureError, Profile, ReferenceProfile, parse_profile_text, reference_profile
from station.errors import InputUnusable

ANALYTIC = ("S1002", "LMA")
BACK_TO_TAPE_MM = 70.0


def load_reference(name: str) -> ReferenceProfile:
    """Return the reference of a name, or of a profile file (MiniProf or CSV).

    Raises
    ------
    InputUnusable
        If it is neither, or the file holds no wheel's profile.
    """
    if name in ANALYTIC:
        return reference_profile(name)
    path = Path(name)
    if not path.is_file():
        raise InputUnusable(
            f"reference {name!r}: neither a known profile ({', '.join(ANALYTIC)}) nor a file"
        )
    profile = read_profile(path)
    try:
        return ReferenceProfile.from_points(path.stem, profile.d_mm - BACK_TO_TAPE_MM, profile.h_mm)
    except MeasureError as error:
        raise InputUnusable(f"{path}: {error}") from error


def read_profile(path: Path) -> Profile:
    """Read a wheel's profile from a MiniProf file or a table (CSV).

    Raises
    ------
    InputUnusable
        If the file cannot be read or holds no wheel's profile.
    """
    try:
        # Old instruments wrote the Latin alphabet of their country; the numbers are ASCII.
        return parse_profile_text(path.read_text(encoding="latin-1"))
    except OSError as error:
        raise InputUnusable(f"{path}: cannot be read ({error.strerror}); give a profile") from error
    except MeasureError as error:
        raise InputUnusable(f"{path}: {error}; give a MiniProf file or a CSV of d,h") from error
