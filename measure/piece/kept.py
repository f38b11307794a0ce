"""Which points on a piece are fit to be measured: not beside its edges, and not bent by blur."""

from dataclasses import replace

import numpy as np

from calib import FloatArray, IntArray, LaserSensor, kernel_of
from measure.laying.bend import bend_px
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece
from measure.piece.match import Match
from measure.placing.pieces import MIN_PIECE

# What spreads light along the stripe, and the kernel that reads it, end within three sigmas.
_REACH_SIGMAS = 3.0
_GAP_MM = 2.0


def inside(match: Match, sheet: SheetPoints, mm_per_px: FloatArray, piece: Piece) -> IntArray:
    """Return the points farther from an edge, or the end of a stretch of stripe, than light bleeds.

    Light of a bright side bleeds over an edge, and a kernel reads across it.

    Parameters
    ----------
    match
        Which side each point lies on, and where.
    sheet
        The points, N of them.
    mm_per_px
        Shape (N,), length of profile that a pixel along the stripe shows.
    piece
        What they lie on.
    """
    width = sheet.stripe.width_px
    reach = _REACH_SIGMAS * np.hypot(width, kernel_of(width)) * mm_per_px
    kept: list[IntArray] = []
    for index, face in enumerate(piece.faces):
        on = np.flatnonzero(match.face == index)
        on = on[np.argsort(match.along_mm[on], kind="stable")]
        along = match.along_mm[on]
        for run in np.split(np.arange(len(on)), np.flatnonzero(np.diff(along) > _GAP_MM) + 1):
            if len(run) < MIN_PIECE:
                continue
            first = max(0.0, along[run[0]]) + reach[on[run]]
            last = min(face.length_mm, along[run[-1]]) - reach[on[run]]
            clear = run[(along[run] >= first) & (along[run] <= last)]
            kept.append(on[clear] if len(clear) >= MIN_PIECE else on[:0])
    return np.concatenate([np.zeros(0, dtype=np.int64), *kept])


def unbent(sheet: SheetPoints, face: IntArray, sensor: LaserSensor, piece: Piece) -> SheetPoints:
    """Take off what blur does to the stripe on round sides; straight ones it leaves in place."""
    is_round = np.array([one.centre_mm is not None for one in piece.faces])[face]
    if not is_round.any():
        return sheet
    stripe = sheet.stripe
    drawn_px = np.where(is_round, bend_px(stripe), 0.0)
    moved = replace(stripe, centre_px=stripe.centre_px - drawn_px[:, None] * stripe.normal)
    bend = sheet.across_mm * (drawn_px / stripe.sigma_px)[:, None]
    return replace(SheetPoints.of(moved, sensor), bend_mm=bend)
