"""Where a file a wheel goes: one name for one wheel, numbered names or a folder for several."""

from collections.abc import Sequence
from pathlib import Path

from station.documents import WheelDocument
from station.errors import InputUnusable

_SAFE = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.-_"


def is_folder(target: Path) -> bool:
    """Tell a folder from a file: one that is there, or a name without an ending."""
    return target.is_dir() or (not target.exists() and not target.suffix)


def check_target(target: Path, option: str) -> None:
    """Refuse, before any work, a place where nothing can be written.

    Raises
    ------
    InputUnusable
        If the folder it is in does not exist.
    """
    if not target.absolute().parent.is_dir():
        raise InputUnusable(f"{option} {target}: no folder {target.parent}; make it first")


def file_for_each(target: Path, wheels: Sequence[WheelDocument], suffix: str) -> list[Path]:
    """Return the path of each wheel's file.

    In a folder they are called by the wheel's source and frame. A file's name is kept for a single
    wheel; several are numbered before its ending, as wheel-1.whl, wheel-2.whl.

    Raises
    ------
    InputUnusable
        If the folder cannot be made.
    """
    if not is_folder(target):
        return _numbered(target, len(wheels))
    try:
        target.mkdir(exist_ok=True)
    except OSError as error:
        raise InputUnusable(f"{target}: cannot be made ({error.strerror})") from error
    taken: set[str] = set()
    return [target / (_name(wheel, taken) + suffix) for wheel in wheels]


def _numbered(target: Path, count: int) -> list[Path]:
    if count == 1:
        return [target]
    return [target.with_stem(f"{target.stem}-{number}") for number in range(1, count + 1)]


def _name(wheel: WheelDocument, taken: set[str]) -> str:
    source = wheel.source.rpartition(".")[0] or wheel.source or "wheel"
    full = source if wheel.frame is None else f"{source}-{wheel.frame}"
    safe = "".join(sign if sign in _SAFE else "_" for sign in full)
    name, number = safe, 1
    while name.lower() in taken:
        number += 1
        name = f"{safe}-{number}"
    taken.add(name.lower())
    return name
