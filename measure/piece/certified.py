"""A reference piece: something machined whose profile is known better than the sensor measures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from calib import FloatArray
from measure.errors import PieceInvalid
from measure.piece.face import PieceFace

CERTIFIED_AT_C = 20.0
"""Temperature of certificates (ISO 1)."""
# Where the piece's temperature is not told, outdoors: half-width of a 95 % interval about 20 C.
_UNKNOWN_K = 20.0
_LARGEST_STEP_MM = 200.0
# A holder without doubt is a weight without end; this is 0.1 um on 100 mm.
_SQUAREST_RAD = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A prism whose section is known.

    Attributes
    ----------
    name, serial
        What is engraved on it.
    faces
        Its lit sides, each from the edge where the one before ends; metal on the right.
    u95_mm
        Of each certified dimension.
    expansion_per_k
        How much it grows by warmth; 0 where it does not matter.
    squareness_deg
        How far, at most in 95 % of cases, the holder lets its length stand from square to the
        sheet, or from `length_in_rig`. A slanted cut is longer, by half the square of the slant.
    held_u95_mm
        How well its holder keeps it in place from check to check; None of one that is put there
        by hand. Then the place where it is seen is a witness too.
    length_in_rig
        Along which direction of the rig frame, of any length, its holder keeps it; None of one
        that stands square to the sheets, as far as these agree.

    Raises
    ------
    PieceInvalid
        If there is no face, faces do not hang together, or a figure is out of range.
    """

    name: str
    serial: str
    faces: tuple[PieceFace, ...]
    u95_mm: float = 0.0
    expansion_per_k: float = 0.0
    squareness_deg: float = 0.5
    held_u95_mm: float | None = None
    length_in_rig: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if not self.faces:
            raise PieceInvalid("the profile has no side; allowed: two corners or more")
        for one, following in zip(self.faces, self.faces[1:], strict=False):
            if not np.abs(one.end_mm - following.start_mm).max() <= 1e-9:
                raise PieceInvalid("a side does not start where the one before ends")
        for figure, value, most in (
            ("u95_mm", self.u95_mm, 1.0),
            ("expansion_per_k", self.expansion_per_k, 1e-3),
            ("squareness_deg", self.squareness_deg, 10.0),
            ("held_u95_mm", self.held_u95_mm or 0.0, 10.0),
        ):
            if not 0.0 <= value <= most:
                raise PieceInvalid(f"{figure} is {value:g}; allowed: 0 to {most:g}")
        if self.length_in_rig is not None:
            length = float(np.linalg.norm(self.length_in_rig))
            if not 0.0 < length < float("inf"):
                raise PieceInvalid(
                    f"length_in_rig is {self.length_in_rig}; allowed: a direction along x, y and z"
                )

    @classmethod
    def from_corners(
        cls,
        name: str,
        serial: str,
        corners: Sequence[Sequence[ArrayLike]],
        *,
        u95_mm: float = 0.0,
        expansion_per_k: float = 0.0,
        squareness_deg: float = 0.5,
        held_u95_mm: float | None = None,
        length_in_rig: tuple[float, float, float] | None = None,
    ) -> Self:
        """Make a piece from its corners, left to right with the metal below.

        Parameters
        ----------
        name, serial
            What it is called.
        corners
            One entry a corner: ``[(x, z)]`` ends a straight side, ``[(x, z), (x, z)]`` is a point
            on the way and the end of a round one. mm.
        u95_mm, expansion_per_k, squareness_deg, held_u95_mm, length_in_rig
            The other attributes.

        Raises
        ------
        PieceInvalid
            If the corners make no profile.
        """
        if len(corners) < 2:
            raise PieceInvalid(f"{len(corners)} corners; allowed: two or more")
        if len(corners[0]) != 1:
            raise PieceInvalid("the first corner is a point; no side can end there")
        faces: list[PieceFace] = []
        start = _point(corners[0][0])
        for corner in corners[1:]:
            end = _point(corner[-1])
            round_one = len(corner) == 2
            faces.append(
                PieceFace.through(start, _point(corner[0]), end)
                if round_one
                else PieceFace(start, end)
            )
            start = end
        return cls(
            name,
            serial,
            tuple(faces),
            u95_mm,
            expansion_per_k,
            squareness_deg,
            held_u95_mm,
            length_in_rig,
        )

    @classmethod
    def step(cls, height_mm: float, *, width_mm: float = 20.0, u95_mm: float = 0.0) -> Self:
        """Make a step of a height, seen over a width on both sides of its wall.

        Raises
        ------
        PieceInvalid
            If a size is not positive, or the step is higher than a sensor sees.
        """
        for figure, value in (("height", height_mm), ("width", width_mm)):
            if not 0.0 < value <= _LARGEST_STEP_MM:
                raise PieceInvalid(
                    f"{figure} {value:g} mm; allowed: more than 0 to {_LARGEST_STEP_MM:g}"
                )
        corners = [[(-width_mm, 0.0)], [(0.0, 0.0)], [(0.0, height_mm)], [(width_mm, height_mm)]]
        return cls.from_corners(f"step of {height_mm:g} mm", "", corners, u95_mm=u95_mm)

    @property
    def corners_mm(self) -> FloatArray:
        """All edges, shape (K + 1, 2)."""
        return np.stack([self.faces[0].start_mm, *(face.end_mm for face in self.faces)])

    @property
    def size_mm(self) -> float:
        """Greatest distance of two edges."""
        off = self.corners_mm[:, None] - self.corners_mm
        return float(np.linalg.norm(off, axis=2).max())

    @property
    def squareness_rad(self) -> float:
        """Standard deviation of its length from square to the sheet, about each axis."""
        return max(float(np.radians(self.squareness_deg)) / 1.96, _SQUAREST_RAD)

    @property
    def terms(self) -> tuple[int, ...]:
        """Of the polynomial that each side follows where the sensor or the piece is off a little.

        Two of a straight side, which is turned; three of a round one, whose radius is another.
        """
        return tuple(2 if side.centre_mm is None else 3 for side in self.faces)

    def samples(self, step_mm: float) -> tuple[FloatArray, FloatArray]:
        """Return points and outward normals about evenly along all faces, (M, 2) each."""
        both = []
        for face in self.faces:
            count = max(1, round(face.length_mm / step_mm))
            both.append(face.points((np.arange(count) + 0.5) * face.length_mm / count))
        points, normals = zip(*both, strict=True)
        return np.concatenate(points), np.concatenate(normals)

    def warmed(self, temperature_c: float | None) -> Self:
        """Return the piece as large as it is at a temperature; unchanged where it is not told."""
        if temperature_c is None or self.expansion_per_k == 0.0:
            return self
        factor = 1.0 + self.expansion_per_k * (temperature_c - CERTIFIED_AT_C)
        faces = tuple(
            PieceFace(
                factor * face.start_mm,
                factor * face.end_mm,
                None if face.centre_mm is None else factor * face.centre_mm,
                face.sweep_rad,
            )
            for face in self.faces
        )
        return replace(self, faces=faces)

    def stretch_u95(self, temperature_c: float | None) -> float:
        """Return what is not known of its size as a whole, a part of it: warmth and slant."""
        by_warmth = self.expansion_per_k * _UNKNOWN_K if temperature_c is None else 0.0
        return float(np.hypot(by_warmth, 0.5 * np.radians(self.squareness_deg) ** 2))


def _point(values: ArrayLike) -> FloatArray:
    point = np.asarray(values, dtype=np.float64)
    if not (point.shape == (2,) and np.isfinite(point).all()):
        raise PieceInvalid(f"corner {values!r}; allowed: x and z in mm")
    return point
