"""Whether a sensor still tells the truth: what it measures of a piece, and the certificate."""

from collections.abc import Sequence

import numpy as np

from calib import LaserSensor, StripePoints
from measure.piece.certified import Piece
from measure.piece.dimensions import dimensions_of, form_of, hidden_faces
from measure.piece.fit import LaidPiece, lay_on_piece
from measure.piece.joined import joined, placement_weights
from measure.piece.place import PiecePlace
from measure.piece.verdict import PieceJudgement, PieceReading, PieceVerdict, Told, judged_by


def judge_piece(
    stripes: Sequence[tuple[str, StripePoints]],
    sensor: LaserSensor,
    piece: Piece,
    *,
    limit_mm: float | None = None,
    temperature_c: float | None = None,
    earlier: PiecePlace | None = None,
) -> PieceJudgement:
    r"""Hold what the sensor measures of a piece against its certificate.

    Parameters
    ----------
    stripes
        Name, and all ridge points, of each picture of the piece.
    sensor
        The sensor under test, with its covariance.
    piece
        The piece, as certified at 20 degrees C.
    limit_mm
        Deviations up to this are allowed however well they are known; None allows only what
        cannot be told from none.
    temperature_c
        Of the piece; None counts its warmth as unknown.
    earlier
        Where the same sensor, with the same calibration, saw it before in a holder that keeps it:
        what has moved since, the sheet or the holder, shows at once, while of the dimensions a
        shift of the sheet changes little.

    Returns
    -------
    PieceJudgement
        ``TRUE`` if every dimension is known well enough and none deviates by more than
        :math:`k\,u_{95}` or the limit, ``DRIFTED`` if one deviates by more than both, else
        ``UNKNOWN``: want of evidence is no pass.

    Notes
    -----
    A dimension is a linear function of the points' distances from the certified profile that no
    motion of the piece changes; its variance is propagated from the points and from the sensor's
    covariance. The pictures share the sensor, and those in which the piece stood still its speckle.
    Of m deviations the largest is judged: k is so large that all m together call a true sensor
    drifted in one case of a hundred, :math:`k = z((1 - 0.01)^{1/m}) / 1.96`, two-sided (Sidak).
    """
    now = piece.warmed(temperature_c)
    laid: list[LaidPiece] = []
    readings: list[PieceReading] = []
    for name, stripe in stripes:
        one = lay_on_piece(stripe, sensor, now)
        readings.append(_reading(name, one))
        if isinstance(one, LaidPiece):
            laid.append(one)
    if not laid:
        why = f"; {readings[0].name}: {readings[0].reason}" if readings else ""
        return _unknown(f"the piece was read in none of {len(readings)} pictures{why}", readings)
    weights = placement_weights([
        now.corners_mm @ one.pose.turn.T + one.pose.shift_mm for one in laid
    ])
    stretch = now.stretch_u95(temperature_c)
    told = [
        joined(parts, weights, sensor.covariance, now, stretch)
        for parts in ([dimensions_of(one) for one in laid], [form_of(one) for one in laid])
    ]
    moved, notes = _moved_since(earlier, readings, now)
    # The sheet's origin is the camera's foot on it.
    foot = np.zeros((1, 2))
    hidden = set.intersection(*(set(hidden_faces(one, one.pose.to_piece(foot))) for one in laid))
    return judged_by([*told[0], *moved], told[1], sorted(hidden), readings, limit_mm, notes)


def _reading(name: str, laid: LaidPiece | str) -> PieceReading:
    if isinstance(laid, str):
        return PieceReading(name, reason=laid)
    return PieceReading(name, len(laid), laid.rms_mm, PiecePlace.of(laid))


def _unknown(reason: str, readings: Sequence[PieceReading]) -> PieceJudgement:
    return PieceJudgement(PieceVerdict.UNKNOWN, reason, (), (), 1.0, tuple(readings))


def _moved_since(
    earlier: PiecePlace | None, readings: Sequence[PieceReading], piece: Piece
) -> tuple[list[Told], list[str]]:
    """Return how far the piece is seen from where it was, and by how much its end is turned."""
    if earlier is None or piece.held_u95_mm is None:
        return [], []
    now = PiecePlace.mean([one.place for one in readings if one.place is not None])
    if now is None:
        return [], ["not held against its earlier place: it was moved between these pictures"]
    away, turned = now.shift_from(earlier)
    arm = 0.5 * piece.size_mm
    held = piece.held_u95_mm
    by_turn = arm * np.hypot(now.turn_u95_rad, earlier.turn_u95_rad)
    return [
        Told("place", 0.0, away, float(np.linalg.norm([now.u95_mm, earlier.u95_mm, held]))),
        Told("turn", 0.0, arm * turned, float(np.hypot(by_turn, held))),
    ], []
