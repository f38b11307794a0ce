"""Finding recordings: files, folders, and what a URL stands for."""

import re
from collections import Counter
from collections.abc import Iterable, MutableMapping, Sequence
from pathlib import Path, PurePosixPath

from station.errors import InputUnusable, StationError
from station.pictures import RECORDING_SUFFIX, natural_order
from station.pipeline import distinct_names
from station.recording import info, parts_of
from station.replay.remote import addresses_under, is_remote, local_path, state_and_size
from station.replay.task import RecordingFiles, Token

_FRAME_BYTES = 2048 * 1088
"""Of a usual camera: how many frames a file has that is not read yet."""
_LATER_PART = re.compile(r"\.(\d{4})(\.mcap)$", re.IGNORECASE)


def find_addresses(sources: Sequence[str | Path]) -> list[str]:
    """Return the addresses of all recording files: those named, and those in folders.

    Raises
    ------
    InputUnusable
        If a source is no recording by its name, a folder has none, or a URL cannot be listed.
    """
    return [address for source in sources for address in _addresses(str(source))]


def _addresses(source: str) -> list[str]:
    if is_remote(source):
        if _is_recording(source.partition("::")[0]):
            return [source]
        found = [one for one in addresses_under(source) if _is_recording(one.partition("::")[0])]
        ordered = sorted(found, key=lambda one: natural_order(Path(one)))
    else:
        path = local_path(source)
        if not path.is_dir():
            if not _is_recording(path.name):
                raise InputUnusable(
                    f"{path}: not a recording ({RECORDING_SUFFIX}) by its name, and no folder; "
                    "`station measure` measures pictures"
                )
            return [str(path)]
        found = [str(one) for one in path.rglob("*") if _is_recording(one.name)]
        ordered = sorted(found, key=lambda one: natural_order(Path(one)))
    if not ordered:
        raise InputUnusable(f"{source}: no recording ({RECORDING_SUFFIX}) in it; give another")
    return ordered


def _is_recording(name: str) -> bool:
    return name.lower().endswith(RECORDING_SUFFIX)


def whole_recordings_at(
    addresses: Sequence[str], refused: MutableMapping[str, str], *, by_address: bool
) -> list[RecordingFiles]:
    """Return the recordings, all files of one together, in the order of their first files.

    Parameters
    ----------
    addresses
        Of files, each once.
    refused
        Is told of what is no whole recording, by name, and why.
    by_address
        Whether a recording is called by its full address; else by as much as tells it from the
        others.

    Raises
    ------
    InputUnusable
        If a file is given twice.
    """
    shortest = distinct_names([Path(one.partition("::")[0]) for one in addresses])
    full = [one if is_remote(one) else str(Path(one).absolute()) for one in addresses]
    names = dict(zip(addresses, full if by_address else shortest, strict=True))
    groups: list[tuple[str, tuple[str, ...], int]] = []
    for address in addresses:
        if is_remote(address):
            continue
        try:
            groups.append(_local(names[address], address))
        except StationError as error:
            refused[names[address]] = str(error)
    groups += _remote([one for one in addresses if is_remote(one)], names)
    return [_described(*group) for group in _first_files(groups)]


def _local(name: str, address: str) -> tuple[str, tuple[str, ...], int]:
    parts = parts_of(Path(address))
    frames = sum(sensor.frames for part in parts for sensor in info(part).sensors)
    return name, tuple(str(part.absolute()) for part in parts), frames


def _remote(
    addresses: Sequence[str], names: MutableMapping[str, str]
) -> list[tuple[str, tuple[str, ...], int]]:
    """Group files by their names alone: to read them is for the one that measures them."""
    known = dict.fromkeys(addresses)
    later: dict[str, list[str]] = {}
    for address in addresses:
        path, chain, rest = address.partition("::")
        first = _LATER_PART.sub(r"\2", path) + chain + rest
        if first != address and first in known:
            later.setdefault(first, []).append(address)
            known.pop(address)
    return [(names[one], (one, *sorted(later.get(one, ()))), 0) for one in known]


def _first_files(
    groups: Iterable[tuple[str, tuple[str, ...], int]],
) -> list[tuple[str, tuple[str, ...], int]]:
    """Leave out what begins with a later file of another: a shell's pattern names those too."""
    groups = list(groups)
    later = Counter(_real(part) for _, parts, _ in groups for part in parts[1:])
    return [group for group in groups if _real(group[1][0]) not in later]


def _real(address: str) -> str:
    return address if is_remote(address) else str(Path(address).resolve())


def _described(name: str, addresses: tuple[str, ...], frames: int) -> RecordingFiles:
    told = [state_and_size(address) for address in addresses]
    size = sum(bytes_ for _, bytes_ in told)
    token = Token.of(name, addresses, [state for state, _ in told])
    return RecordingFiles(name, addresses, token, frames or max(1, size // _FRAME_BYTES))


def file_name(address: str) -> str:
    """Return the name of the file at an address."""
    return PurePosixPath(address.partition("::")[0]).name
