"""The sides of a reference piece: straight or round, from one edge to the next."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from calib import FloatArray, frozen
from measure.errors import PieceInvalid

_SHORTEST_MM = 1e-3
_LARGEST_RADIUS_MM = 1e4


@dataclass(frozen=True, slots=True, eq=False)
class PieceFace:
    """One side of a piece, in the piece's frame (x, z), mm; metal lies on the right of its way.

    Attributes
    ----------
    start_mm, end_mm
        Shape (2,), its edges.
    centre_mm
        Shape (2,), of a round side; None of a straight one.
    sweep_rad
        Angle from start to end about the centre, counterclockwise positive; 0 of a straight side.
    tangent
        Shape (2,), unit, from the start to the end.
    normal
        Shape (2,), unit, out of the metal of a straight side.

    Raises
    ------
    PieceInvalid
        If it has no length.
    """

    start_mm: FloatArray
    end_mm: FloatArray
    centre_mm: FloatArray | None = None
    sweep_rad: float = 0.0
    tangent: FloatArray = field(init=False, repr=False)
    normal: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("start_mm", "end_mm"):
            object.__setattr__(self, name, frozen(getattr(self, name), (2,), name))
        if not self.length_mm >= _SHORTEST_MM:
            raise PieceInvalid(
                f"two corners at ({self.start_mm[0]:g}, {self.start_mm[1]:g}) mm; allowed: "
                "corners that differ"
            )
        chord = self.end_mm - self.start_mm
        along = chord / np.linalg.norm(chord)
        object.__setattr__(self, "tangent", frozen(along, (2,), "tangent"))
        object.__setattr__(self, "normal", frozen([-along[1], along[0]], (2,), "normal"))

    @classmethod
    def through(cls, start_mm: FloatArray, middle_mm: FloatArray, end_mm: FloatArray) -> Self:
        """Make the round side through three points.

        Raises
        ------
        PieceInvalid
            If no circle of reasonable size goes through them.
        """
        chords = np.stack([middle_mm - start_mm, end_mm - start_mm])
        twice_area = float(np.linalg.det(chords))
        lengths = np.linalg.norm([*chords, end_mm - middle_mm], axis=1)
        if not float(lengths.prod()) <= 2.0 * _LARGEST_RADIUS_MM * abs(twice_area):
            raise PieceInvalid(
                f"no arc of less than {_LARGEST_RADIUS_MM / 1000.0:g} m goes through "
                f"({middle_mm[0]:g}, {middle_mm[1]:g}) mm; give a straight side or another point"
            )
        centre = start_mm + np.linalg.solve(2.0 * chords, (chords**2).sum(axis=1))
        turns = np.unwrap([np.arctan2(*(p - centre)[::-1]) for p in (start_mm, end_mm)])
        around = 2.0 * np.pi if twice_area > 0.0 else -2.0 * np.pi
        sweep = float((turns[1] - turns[0]) % around)
        return cls(start_mm, end_mm, frozen(centre, (2,), "centre_mm"), sweep)

    @property
    def radius_mm(self) -> float:
        """Radius of a round side; infinite of a straight one."""
        if self.centre_mm is None:
            return float("inf")
        return float(np.linalg.norm(self.start_mm - self.centre_mm))

    @property
    def side(self) -> float:
        """1 where a round side bulges out of the metal, -1 where it is hollow."""
        return -float(np.sign(self.sweep_rad))

    @property
    def length_mm(self) -> float:
        """Length along the side."""
        if self.centre_mm is None:
            return float(np.linalg.norm(self.end_mm - self.start_mm))
        return abs(self.sweep_rad) * self.radius_mm

    def place(self, points_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how far along the side, and how far out of the metal, points lie, (N,) each."""
        if self.centre_mm is None:
            off = points_mm - self.start_mm
            return off @ self.tangent, off @ self.normal
        arm = points_mm - self.centre_mm
        angle = np.arctan2(arm[:, 1], arm[:, 0]) - self._middle_rad
        # From the middle of the arc the angle jumps on the far side of the circle only.
        angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
        along = self.radius_mm * (0.5 * abs(self.sweep_rad) - self.side * angle)
        return along, self.side * (np.linalg.norm(arm, axis=1) - self.radius_mm)

    def points(self, along_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and outward unit normals at places along the side, (N, 2) each."""
        if self.centre_mm is None:
            points = self.start_mm + along_mm[:, None] * self.tangent
            return points, np.broadcast_to(self.normal, points.shape)
        angle = self._middle_rad - self.side * (
            along_mm / self.radius_mm - 0.5 * abs(self.sweep_rad)
        )
        arm = np.column_stack([np.cos(angle), np.sin(angle)])
        return self.centre_mm + self.radius_mm * arm, self.side * arm

    @property
    def _middle_rad(self) -> float:
        if self.centre_mm is None:
            raise ValueError("a straight side has no centre")
        arm = self.start_mm - self.centre_mm
        return float(np.arctan2(arm[1], arm[0]) + 0.5 * self.sweep_rad)
