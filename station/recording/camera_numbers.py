"""A camera's numbers as a recording keeps them, read without the mathematics behind them.

Importing `calib` or the documents would make a new recorder late by a second.
"""

import json
from dataclasses import dataclass, fields
from typing import Self


@dataclass(frozen=True, slots=True)
class CameraNumbers:
    """The camera of a calibration, as OpenCV names its numbers; px."""

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    k1: float = 0.0
    k2: float = 0.0
    p1: float = 0.0
    p2: float = 0.0
    k3: float = 0.0

    @classmethod
    def of_calibration(cls, document: bytes) -> Self:
        """Read the camera in a calibration.json that the station has checked before."""
        camera = json.loads(document)["camera"]
        return cls(**{each.name: camera[each.name] for each in fields(cls) if each.name in camera})
