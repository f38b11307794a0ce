"""Wheel profiles from files, and the reference that a name or a file stands for."""

from pathlib import Path

from measure import (
    MeasureError,
    MiniProfText,
    ReferenceProfile,
    parse_profile_text,
    reference_profile,
)
from station.documents import ReferenceDocument
from station.errors import InputUnusable

ANALYTIC = ("S1002", "LMA")
BACK_TO_TAPE_MM = 70.0
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


def load_reference(name: str) -> ReferenceProfile:
    """Return the reference of a name, of a registered new wheel, or of a profile file.

    Raises
    ------
    InputUnusable
        If it is none of them, or the file holds no wheel's profile.
    """
    if name in ANALYTIC:
        return reference_profile(name)
    path = Path(name)
    if not path.is_file():
        raise InputUnusable(
            f"reference {name!r}: neither a known profile ({', '.join(ANALYTIC)}) nor a file"
        )
    try:
        if is_json(path):
            return read_reference(path).reference()
        profile = read_profile(path).profile
        return ReferenceProfile.from_points(path.stem, profile.d_mm - BACK_TO_TAPE_MM, profile.h_mm)
    except MeasureError as error:
        raise InputUnusable(f"{path}: {error}") from error


def read_reference(path: Path) -> ReferenceDocument:
    """Read the file of a registered new wheel.

    Raises
    ------
    InputUnusable
        If it is something else.
    """
    if b'"treadline-measurement"' in _content(path)[:4096]:
        raise InputUnusable(
            f"{path}: results of a measurement, no reference; make one of them by "
            "`station reference register`"
        )
    return ReferenceDocument.read(path)


def read_profile(path: Path) -> MiniProfText:
    """Read a wheel's profile, and what its header says, from a MiniProf file or a table (CSV).

    Raises
    ------
    InputUnusable
        If the file cannot be read or holds no wheel's profile.
    """
    try:
        return parse_profile_text(_decoded(_content(path)))
    except MeasureError as error:
        raise InputUnusable(f"{path}: {error}; give a MiniProf file or a CSV of d,h") from error


def is_json(path: Path) -> bool:
    """Tell a JSON document from a profile, by how it starts."""
    return _content(path).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{")


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputUnusable(f"{path}: cannot be read ({error.strerror}); give a profile") from error


def _decoded(content: bytes) -> str:
    """Return the text of a file that does not say how it is coded; the numbers are ASCII."""
    if content.startswith(_UTF_16):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Old instruments wrote the Latin alphabet of their country, one byte a letter.
        return content.decode("latin-1")
