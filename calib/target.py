"""Planar calibration targets: grids of dots and chessboards, and the text that names them."""

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from calib.arrays import FloatArray
from calib.errors import TargetSpecInvalid

_ALLOWED = "dots:ROWSxCOLS:PITCH_MM[:dark][:d=DIAMETER_MM] or chessboard:ROWSxCOLS:PITCH_MM"
_SPEC = re.compile(
    r"(?P<kind>dots|chessboard):(?P<rows>\d+)x(?P<cols>\d+):(?P<pitch>\d+(?:\.\d+)?)"
    r"(?P<dark>:dark)?(?::d=(?P<diameter>\d+(?:\.\d+)?))?"
)


@dataclass(frozen=True, slots=True)
class Target:
    """A planar grid of `rows` x `cols` points, `pitch_mm` apart, in its own frame (TCF).

    Point (row, col) lies at ``(col * pitch_mm, row * pitch_mm, 0)``; z points away from the
    camera that sees rows run down and columns run right.

    Attributes
    ----------
    kind
        ``"dots"``, or ``"chessboard"`` with its inner corners as points.
    rows, cols
        Points along y and x, at least 2 each and 3 along one.
    pitch_mm
        Distance of neighbours.
    dark
        Dots are darker than their ground (printed), not brighter (lit).
    diameter_mm
        Diameter of a dot where known; None: as the pictures show it. The picture of its centre is
        corrected for the eccentricity of a projected circle by it.

    Raises
    ------
    TargetSpecInvalid
        If a number is out of range.
    """

    kind: Literal["dots", "chessboard"]
    rows: int
    cols: int
    pitch_mm: float
    dark: bool = False
    diameter_mm: float | None = None

    def __post_init__(self) -> None:
        if not (min(self.rows, self.cols) >= 2 and max(self.rows, self.cols) >= 3):
            raise TargetSpecInvalid(
                f"target of {self.rows}x{self.cols} points; allowed: 2x3 and larger"
            )
        if not 0.0 < self.pitch_mm < np.inf:
            raise TargetSpecInvalid(f"target pitch {self.pitch_mm} mm; allowed: more than 0")
        if self.diameter_mm is not None and not 0.0 < self.diameter_mm < self.pitch_mm:
            raise TargetSpecInvalid(
                f"dot diameter {self.diameter_mm} mm; allowed: between 0 and the pitch "
                f"of {self.pitch_mm} mm"
            )

    @classmethod
    def parse(cls, text: str) -> "Target":
        """Read a TARGET text.

        Raises
        ------
        TargetSpecInvalid
            If the text is not of the form, or a number is out of range.

        Examples
        --------
        >>> Target.parse("dots:7x8:12:d=6").diameter_mm
        6.0
        >>> str(Target.parse("chessboard:9x6:5"))
        'chessboard:9x6:5'
        """
        match = _SPEC.fullmatch(text.strip())
        if match is None or (
            match["kind"] == "chessboard" and (match["dark"] or match["diameter"])
        ):
            raise TargetSpecInvalid(f"target {text!r} does not parse; allowed: {_ALLOWED}")
        return cls(
            kind="dots" if match["kind"] == "dots" else "chessboard",
            rows=int(match["rows"]),
            cols=int(match["cols"]),
            pitch_mm=float(match["pitch"]),
            dark=match["dark"] is not None,
            diameter_mm=float(match["diameter"]) if match["diameter"] else None,
        )

    def __str__(self) -> str:
        dark = ":dark" if self.dark else ""
        diameter = f":d={self.diameter_mm:g}" if self.diameter_mm is not None else ""
        return f"{self.kind}:{self.rows}x{self.cols}:{self.pitch_mm:g}{dark}{diameter}"

    @property
    def points_mm(self) -> FloatArray:
        """All points in TCF, row by row, shape (rows * cols, 3)."""
        row, col = np.divmod(np.arange(self.rows * self.cols), self.cols)
        return np.column_stack([col, row, np.zeros(row.size)]) * self.pitch_mm
