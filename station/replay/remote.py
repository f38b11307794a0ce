"""Files at URLs, by fsspec: listed, told apart, and fetched piecewise to where they can be read."""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote

from station.errors import InputUnusable

_PIECE_BYTES = 8 << 20
_LOCAL = ("file://", "local://")


def is_remote(address: str) -> bool:
    """Tell a URL from the path of a file, also from one that is written as a URL."""
    return "://" in address and not (address.startswith(_LOCAL) and "::" not in address)


def local_path(address: str) -> Path:
    """Return the path that an address that is not remote stands for."""
    for prefix in _LOCAL:
        if address.startswith(prefix):
            return Path(unquote(address.removeprefix(prefix)))
    return Path(address)


def addresses_under(url: str) -> list[str]:
    """Return the addresses of all files under a URL.

    Raises
    ------
    InputUnusable
        If it cannot be listed.
    """
    head, chain, rest = url.partition("::")
    protocol = head.partition("://")[0]
    with _one_line(url):
        files, root = _opened(url)
        found = [str(path) for path in files.find(root)]
    return [path if "://" in path else f"{protocol}://{path}{chain}{rest}" for path in found]


def state_and_size(address: str) -> tuple[str, int]:
    """Return what changes when a file does, and its bytes.

    Raises
    ------
    InputUnusable
        If there is no such file.
    """
    if not is_remote(address):
        about = Path(address).stat()
        return f"{about.st_size} {about.st_mtime_ns}", about.st_size
    with _one_line(address):
        files, path = _opened(address)
        return str(files.ukey(path)), int(files.size(path) or 0)


def fetched(addresses: Sequence[str], folder: Path) -> list[Path]:
    """Return where the files can be read: in the folder, or at their own paths.

    Raises
    ------
    InputUnusable
        If one cannot be read, or the disk takes no more.
    """
    return [
        _fetch(address, folder) if is_remote(address) else local_path(address)
        for address in addresses
    ]


def _fetch(address: str, folder: Path) -> Path:
    # Files of one recording lie in one folder and find each other by their names.
    copy = folder / PurePosixPath(address.partition("::")[0]).name
    with _one_line(address):
        files, path = _opened(address)
        with files.open(path, "rb", block_size=_PIECE_BYTES) as source, copy.open("wb") as target:
            while piece := source.read(_PIECE_BYTES):
                target.write(piece)
    return copy


def _opened(url: str) -> tuple[Any, str]:
    import fsspec  # noqa: PLC0415  costs 0.1 s: only where there is a URL

    # What was listed a minute ago may be another file now.
    files, path = fsspec.core.url_to_fs(url, use_listings_cache=False)
    return files, str(path)


@contextmanager
def _one_line(url: str) -> Generator[None]:
    try:
        yield
    except ImportError as error:
        raise InputUnusable(
            f"{url}: {error}; install what reads it, for s3:// `pip install treadline[s3]`"
        ) from error
    except FileNotFoundError as error:
        raise InputUnusable(f"{url}: not there; give a recording or a folder") from error
    except Exception as error:
        # Each kind of store has errors of its own, most of them derived from nothing.
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputUnusable(f"{url}: cannot be read ({said}); give an address in reach") from error
