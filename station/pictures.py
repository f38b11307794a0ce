"""Pictures from files: what counts as one, its 8-bit grey, a folder's order."""

import re
from pathlib import Path

import cv2
import numpy as np

from calib import Picture
from station.errors import InputUnusable

PICTURE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
RECORDING_SUFFIX = ".mcap"

_PNG_SIGNATURE, _PNG_END = b"\x89PNG\r\n\x1a\n", b"IEND"
# The last chunk takes 12 bytes; some writers pad the file.
_PNG_TAIL = 64

_SOURCE_ALLOWED = "a recording (.mcap), a picture (PNG, JPEG, TIFF, BMP) or a folder of pictures"


def natural_order(path: Path) -> tuple[str | int, ...]:
    """Sort key under which ``im2.png`` comes before ``im10.png``."""
    parts = re.split(r"(\d+)", path.name.lower())
    return tuple(int(part) if i % 2 else part for i, part in enumerate(parts))


def pictures_of(source: Path) -> list[Path]:
    """Return the picture files that a picture or a folder of pictures stands for, in natural order.

    Raises
    ------
    InputUnusable
        If there is no such file, it is not a picture by its name, or the folder holds none.
    """
    if source.is_dir():
        found = [path for path in source.iterdir() if _is_picture_file(path)]
        if not found:
            raise InputUnusable(
                f"{source}: a folder without pictures; allowed: PNG, JPEG, TIFF, BMP in it"
            )
        return sorted(found, key=natural_order)
    if not source.exists():
        raise InputUnusable(f"{source}: no such file or folder; give {_SOURCE_ALLOWED}")
    if source.suffix.lower() not in PICTURE_SUFFIXES:
        raise InputUnusable(f"{source}: not a known kind of file; allowed: {_SOURCE_ALLOWED}")
    return [source]


def _is_picture_file(path: Path) -> bool:
    # Hidden ones are what file managers leave behind, as ._im1.png of macOS.
    known = path.suffix.lower() in PICTURE_SUFFIXES and not path.name.startswith(".")
    return known and path.is_file()


def read_picture(path: Path) -> Picture:
    """Read a picture as 8-bit grey, shape (H, W).

    Colour is turned to grey, transparency ignored. Deeper pictures are scaled from the smallest of
    8, 10, 12 or 16 bits that holds their brightest pixel, so that full scale stays full scale.

    Raises
    ------
    InputUnusable
        If the file cannot be read or is not a picture.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputUnusable(f"{path}: cannot be read ({error.strerror}); give a picture") from error
    pixels = _decode(data)
    if pixels is None:
        raise InputUnusable(
            f"{path}: {len(data)} bytes that are no whole picture; allowed: PNG, JPEG, TIFF, BMP"
        )
    return _grey(_eight_bit(pixels, path))


def _decode(data: bytes) -> np.ndarray | None:
    if not data or _is_png_cut_short(data):
        return None
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        return None


def _is_png_cut_short(data: bytes) -> bool:
    # libpng would tell of it on stderr, past every log and beside the one line of a refusal.
    return data.startswith(_PNG_SIGNATURE) and _PNG_END not in data[-_PNG_TAIL:]


def _eight_bit(pixels: np.ndarray, path: Path) -> np.ndarray:
    if pixels.dtype == np.uint8:
        return pixels
    if pixels.dtype != np.uint16:
        raise InputUnusable(f"{path}: pixels of type {pixels.dtype}; allowed: 8 or 16 bits")
    brightest = int(pixels.max())
    full_scale = next(2**bits - 1 for bits in (8, 10, 12, 16) if brightest < 2**bits)
    return np.asarray(np.rint(pixels * (255.0 / full_scale)), dtype=np.uint8)


def _grey(pixels: np.ndarray) -> Picture:
    if pixels.ndim == 2:
        return np.ascontiguousarray(pixels)
    if pixels.shape[2] == 2:
        return np.ascontiguousarray(pixels[:, :, 0])
    if pixels.shape[2] == 4:
        pixels = pixels[:, :, :3]
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_BGR2GRAY))
