"""A camera's numbers as a recording keeps them, read without the mathematics behind them.

Importing `calib` or the documents would make a new recorder late by a second.
"""

import json
from dataclasses import dataclass, fields
from typing import Protocol, Self


class Camera(Protocol):
    """OpenCV's camera model, by its numbers; `calib.CameraModel` is one."""

    @property
    def width(self) -> int: ...  # noqa: D102  all as OpenCV names them
    @property
    def height(self) -> int: ...  # noqa: D102
    @property
    def fx(self) -> float: ...  # noqa: D102
    @property
    def fy(self) -> float: ...  # noqa: D102
    @property
    def cx(self) -> float: ...  # noqa: D102
    @property
    def cy(self) -> float: ...  # noqa: D102
    @property
    def k1(self) -> float: ...  # noqa: D102
    @property
    def k2(self) -> float: ...  # noqa: D102
    @property
    def p1(self) -> float: ...  # noqa: D102
    @property
    def p2(self) -> float: ...  # noqa: D102
    @property
    def k3(self) -> float: ...  # noqa: D102


@dataclass(frozen=True, slots=True)
class CameraNumbers:
    """The camera of a calibration."""

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
