"""Whether sensors still stand to each other as their rig says: one piece that all of them see."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib import FloatArray, Rig, StripePoints
from measure.piece.certified import Piece
from measure.piece.dimensions import dimensions_of, form_of, hidden_faces
from measure.piece.joined import joined, placement_weights
from measure.piece.rig.laying import LaidOnRig, lay_on_rig
from measure.piece.rig.relative import NOTHING_ALONG, SHIFT, TWIST, relative_of
from measure.piece.verdict import (
    PieceJudgement,
    PiecePower,
    PieceReading,
    PieceVerdict,
    Told,
    judged_by,
)

_FOUND_95 = 1.645 / 1.96
"""Beyond its limit by this many u95 a drift is found in 95 % of cases, one-sided."""


def judge_piece_on_rig(
    shots: Sequence[tuple[str, Mapping[str, StripePoints]]],
    rig: Rig,
    piece: Piece,
    *,
    limit_mm: float | None = None,
    temperature_c: float | None = None,
) -> PieceJudgement:
    r"""Hold what the sensors of a rig measure together of a piece against its certificate.

    Parameters
    ----------
    shots
        Name of each, and all ridge points of each sensor's picture in it. The piece stands still
        while the pictures of one shot are taken.
    rig
        The rig under test, with its covariance.
    piece
        The piece, as certified at 20 degrees C: long enough to be in all sheets.
    limit_mm, temperature_c
        As for `judge_piece`.

    Returns
    -------
    PieceJudgement
        As of `judge_piece`: ``TRUE``, ``DRIFTED`` or ``UNKNOWN``. Among the deviations are, for
        each sensor but the first, its shift along the piece's x and z, and its twist about the
        piece's length, mm at half the piece's size. `powers` tells which drift of these would be
        found. ``UNKNOWN`` also where no shot has the piece in the sheets of all sensors.

    Raises
    ------
    ValueError
        If a shot names a sensor that the rig has not.

    Notes
    -----
    The piece is a prism in space: its place and the direction of its length are fitted to the
    points of all sensors, whose sheets need not lie in one plane. Its length points where its
    holder keeps it, within its squareness; where that is not told, where the sheets' normals do on
    the mean, within their own spread besides.
    Dimensions that no motion of the piece changes, and their variance, are then those of
    `judge_piece`, with the covariance of the whole rig. Where sheets stand l apart, a slant that
    is known to :math:`\sigma` shifts one sensor's section by :math:`l \sigma`: sheets that lie
    close together, or a holder that keeps the length well, tell most. Of a shift along the piece's
    length a prism says nothing.
    """
    for name, shot in shots:
        unknown = sorted(set(shot) - set(rig.names))
        if unknown:
            raise ValueError(f"{name}: the rig has no sensor {unknown[0]}; allowed: {rig.names}")
    now = piece.warmed(temperature_c)
    laid: list[LaidOnRig] = []
    readings: list[PieceReading] = []
    for name, shot in shots:
        one, reasons = lay_on_rig(shot, rig, now)
        readings += _readings(name, shot, one, reasons, rig)
        if one is not None:
            laid.append(one)
    apart = _unjoined(laid, rig)
    if not laid or apart:
        return _unknown(apart, readings)
    weights = placement_weights([_corners_in_rig(one) for one in laid])
    stretch = now.stretch_u95(temperature_c)
    dimensions, relative, form = (
        joined(parts, weights, rig.covariance, now, stretch)
        for parts in (
            [dimensions_of(one) for one in laid],
            [list(relative_of(one, rig.names)) for one in laid],
            [form_of(one) for one in laid],
        )
    )
    relative += _untold(relative, rig)
    hidden = set.intersection(*(set(hidden_faces(one, _cameras(one, rig))) for one in laid))
    notes = [NOTHING_ALONG] if len(rig.sensors) > 1 else []
    judged = judged_by([*dimensions, *relative], form, sorted(hidden), readings, limit_mm, notes)
    return judged.with_powers(_powers(relative, judged.coverage_factor, now))


def _readings(
    shot: str,
    stripes: Mapping[str, StripePoints],
    laid: LaidOnRig | None,
    reasons: Mapping[str, str],
    rig: Rig,
) -> list[PieceReading]:
    readings = []
    for name in stripes:
        if name in reasons or laid is None:
            readings.append(PieceReading(shot, reason=reasons[name], sensor=name))
            continue
        off = laid.outside_mm[laid.sensor == rig.names.index(name)]
        rms = float(np.sqrt(np.mean(off**2)))
        readings.append(PieceReading(shot, len(off), rms, sensor=name))
    return readings


def _unjoined(laid: Sequence[LaidOnRig], rig: Rig) -> str:
    """Return which sensors were in no shot with all others that saw the piece; empty if none."""
    together = {frozenset(np.unique(one.sensor).tolist()) for one in laid}
    joined_ones = {index for some in together if len(some) > 1 for index in some}
    missing = [
        name
        for index, name in enumerate(rig.names)
        if index not in joined_ones and len(rig.sensors) > 1
    ]
    return ", ".join(missing)


def _unknown(apart: str, readings: Sequence[PieceReading]) -> PieceJudgement:
    blind = next((one for one in readings if one.reason), None)
    why = f"; {blind.name} {blind.sensor}: {blind.reason}" if blind else ""
    reason = (
        f"{apart}: never on the piece together with another sensor{why}; hold it where all sheets "
        "meet it"
        if apart
        else f"the piece was read in none of {len(readings)} pictures{why}"
    )
    return PieceJudgement(PieceVerdict.UNKNOWN, reason, (), (), 1.0, tuple(readings))


def _corners_in_rig(laid: LaidOnRig) -> FloatArray:
    return laid.rig_from_piece.apply(np.insert(laid.piece.corners_mm, 1, 0.0, axis=1))


def _cameras(laid: LaidOnRig, rig: Rig) -> FloatArray:
    """Return where the cameras stand in the piece's section, shape (K, 2)."""
    centres = np.stack([each.rig_from_camera.translation_mm for each in rig.sensors])
    return laid.rig_from_piece.inverse().apply(centres)[:, [0, 2]]


def _untold(relative: Sequence[Told], rig: Rig) -> list[Told]:
    """Return the shifts that no picture tells: want of evidence is no pass."""
    seen = {one.name for one in relative}
    wanted = [f"{SHIFT} {axis} {name}" for name in rig.names[1:] for axis in "xz"]
    return [Told(name, 0.0, 0.0, float("inf")) for name in wanted if name not in seen]


def _powers(relative: Sequence[Told], factor: float, piece: Piece) -> list[PiecePower]:
    powers = []
    for one in relative:
        found_mm = (factor + _FOUND_95) * one.u95_mm
        if one.kind == TWIST:
            powers.append(PiecePower(one.name, 2.0 * found_mm / piece.size_mm, "rad"))
        else:
            powers.append(PiecePower(one.name, found_mm, "mm"))
    return powers
