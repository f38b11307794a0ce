"""Small grey JPEGs of the target in each picture, made while the frames stream by."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from calib import Picture
from station.pipeline import read_frames
from station.report.evidence import PictureEvidence

LARGEST_BYTES = 56_000
"""Of one JPEG: 20 of them, base64 and all else stay under 3 MB."""

_MARGIN = 0.12
_QUALITIES = (85, 75, 65, 50)
_DIM_BELOW = 200.0


@dataclass(frozen=True, slots=True)
class Box:
    """A part of a picture, px; pixel (0, 0) is the centre of the top-left pixel."""

    left: int
    top: int
    width: int
    height: int

    @classmethod
    def around(cls, picture: PictureEvidence, width: int, height: int) -> "Box":
        """Return the part around all points seen, with a margin, within a picture's size."""
        low, high = picture.seen_px.min(axis=0), picture.seen_px.max(axis=0)
        margin = _MARGIN * float((high - low).max()) + 8.0
        size = np.array([width, height])
        first = np.clip(np.floor(low - margin), 0, size - 1).astype(int)
        last = np.clip(np.ceil(high + margin), first, size - 1).astype(int)
        return cls(*first.tolist(), *(last - first + 1).tolist())

    @property
    def view_box(self) -> str:
        """The part as SVG's viewBox: from the corner of its first pixel."""
        return f"{self.left - 0.5} {self.top - 0.5} {self.width} {self.height}"


@dataclass(frozen=True, slots=True)
class Crop:
    """A part of a picture as a JPEG; `gain` is how much brighter than taken it is shown."""

    box: Box
    jpeg: bytes
    gain: float

    @property
    def url(self) -> str:
        """The JPEG as a data URL."""
        return "data:image/jpeg;base64," + base64.b64encode(self.jpeg).decode("ascii")


def crops_of(
    sources: Sequence[Path], boxes: Mapping[str, Box], others: frozenset[str]
) -> dict[str, Crop]:
    """Read the sources again, and keep the boxes of the pictures named.

    Parameters
    ----------
    sources
        As they were calibrated from; those that hold points only are passed over.
    boxes
        What to keep, by the picture's name.
    others
        Names of pictures to keep whole.

    Returns
    -------
    crops
        By name. A name that two pictures bear has no crop: it is not certain whose it is.

    Raises
    ------
    InputUnusable
        If a source cannot be used.
    RecordingUnreadable
        If a recording is damaged.
    """
    crops: dict[str, Crop] = {}
    twice: set[str] = set()
    for frame in read_frames([path for path in sources if path.suffix.lower() != ".csv"]):
        height, width = frame.picture.shape
        whole = Box(0, 0, width, height) if frame.name in others else None
        box = boxes.get(frame.name, whole)
        if box is None:
            continue
        if frame.name in crops:
            twice.add(frame.name)
        crops[frame.name] = crop_of(frame.picture, box)
    return {name: crop for name, crop in crops.items() if name not in twice}


def crop_of(picture: Picture, box: Box) -> Crop:
    """Cut a box out of a picture; brighten it where it is dim, and pack it small."""
    part = picture[box.top : box.top + box.height, box.left : box.left + box.width]
    bright = float(np.percentile(part, 99.5))
    gain = max(1.0, _DIM_BELOW / max(bright, 1.0)) if bright < _DIM_BELOW else 1.0
    shown = cv2.convertScaleAbs(part, alpha=gain)
    return Crop(box, _packed(np.asarray(shown, dtype=np.uint8)), gain)


def _packed(part: Picture) -> bytes:
    """Return the best JPEG that is small enough, at half the size where none is."""
    while True:
        for quality in _QUALITIES:
            _, data = cv2.imencode(".jpg", part, [cv2.IMWRITE_JPEG_QUALITY, quality])
            if data.size <= LARGEST_BYTES or min(part.shape) < 2:
                return bytes(data)
        part = np.asarray(cv2.resize(part, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
