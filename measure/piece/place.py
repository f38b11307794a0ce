"""Where a piece lies on the sheet, and whether a holder that keeps it shows it there again."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from measure.gauging.uncertainty import COVERAGE_FACTOR, MODEL_FLOOR_MM
from measure.piece.fit import LaidPiece

_STILL_MM = 1.0


@dataclass(frozen=True, slots=True)
class PiecePlace:
    """Where the middle of a piece's corners lies, and how it is turned.

    Attributes
    ----------
    s_mm, t_mm
        On the sheet, in the frame that the light plane alone decides (`calib.SheetFrame`).
    turn_rad
        Of the piece's x, from the sheet's s to its t.
    u95_mm, turn_u95_rad
        By the points: along the direction that is told worst, and of the turn.
    """

    s_mm: float
    t_mm: float
    turn_rad: float
    u95_mm: float
    turn_u95_rad: float

    @classmethod
    def of(cls, laid: LaidPiece) -> "PiecePlace":
        """Take it from the pose to which the points were laid."""
        turn = laid.pose.turn
        corners = laid.piece.corners_mm.mean(axis=0)
        s, t = turn @ corners + laid.pose.shift_mm
        arm = laid.points_mm - corners
        turning = laid.normal[:, 1] * arm[:, 0] - laid.normal[:, 0] * arm[:, 1]
        design = np.column_stack([laid.normal, turning]) / laid.sigma_mm[:, None]
        information = design.T @ design
        # Along a single step nothing is told: a trace of stiffness makes that an endless doubt.
        covariance = np.linalg.inv(information + 1e-6 * np.eye(3))
        worst = float(np.linalg.eigvalsh(covariance[:2, :2])[-1]) + MODEL_FLOOR_MM**2
        by_turn = float(covariance[2, 2]) + (MODEL_FLOOR_MM / laid.piece.size_mm) ** 2
        return cls(
            float(s),
            float(t),
            float(np.arctan2(turn[1, 0], turn[0, 0])),
            COVERAGE_FACTOR * worst**0.5,
            COVERAGE_FACTOR * by_turn**0.5,
        )

    def shift_from(self, other: "PiecePlace") -> tuple[float, float]:
        """Return how far it lies from another place, mm, and how much it is turned, rad."""
        turned = (self.turn_rad - other.turn_rad + np.pi) % (2.0 * np.pi) - np.pi
        away = np.hypot(self.s_mm - other.s_mm, self.t_mm - other.t_mm)
        return float(away), float(turned)

    @classmethod
    def mean(cls, places: Sequence["PiecePlace"]) -> "PiecePlace | None":
        """Return the place that pictures of a piece at rest share; None if it was moved.

        Their noise is taken for the same in all: at rest the speckle is.
        """
        first = places[0]
        if any(first.shift_from(one)[0] > _STILL_MM for one in places):
            return None
        return cls(
            float(np.mean([one.s_mm for one in places])),
            float(np.mean([one.t_mm for one in places])),
            first.turn_rad + float(np.mean([one.shift_from(first)[1] for one in places])),
            max(one.u95_mm for one in places),
            max(one.turn_u95_rad for one in places),
        )
