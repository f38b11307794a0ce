"""The reference profile that a name or a file stands for."""

from pathlib import Path

from measure import MeasureError, ReferenceProfile, parse_profile_text, reference_profile
from station.errors import InputUnusable

ANALYTIC = ("S1002", "LMA")


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
    try:
        text = path.read_text(encoding="latin-1")
        profile = parse_profile_text(text)
        return ReferenceProfile.from_points(path.stem, profile.d_mm - 70.0, profile.h_mm)
    except OSError as error:
        raise InputUnusable(
            f"reference {name!r}: neither a known profile ({', '.join(ANALYTIC)}) nor a file that "
            f"can be read ({error.strerror})"
        ) from error
    except MeasureError as error:
        raise InputUnusable(f"{path}: {error}") from error
