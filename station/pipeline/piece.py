"""Whether a sensor still tells the truth: pictures of a piece against its certificate."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from calib import StripePoints
from measure import Piece, PiecePlace, judge_piece
from station.documents import CalibrationDocument, PieceCheck, piece_check
from station.errors import InputUnusable
from station.pipeline.piece_stripes import stripes_of
from station.progress import Progress, silent
from station.software import SOFTWARE


def check_piece(
    sources: Sequence[Path],
    calibration: CalibrationDocument,
    piece: Piece,
    *,
    laser_off: Sequence[Path] = (),
    limit_mm: float | None = None,
    temperature_c: float | None = None,
    since: PieceCheck | None = None,
    progress: Progress = silent,
) -> PieceCheck:
    """Measure a reference piece in all pictures of the sources, and say whether it comes out right.

    Parameters
    ----------
    sources
        Pictures of the piece held in the sheet, in one placement or several.
    calibration
        Of the sensor under test.
    piece
        What its certificate says.
    laser_off
        The same with the laser off: one picture for all, or one for each.
    limit_mm, temperature_c
        As for `measure.judge_piece`.
    since
        An earlier check by the same calibration: a piece whose holder keeps it must be seen where
        it was then.
    progress
        Told how far it is.

    Returns
    -------
    PieceCheck
        A document to keep. Pictures without the piece are in it, with the reason; that nothing
        could be said is a verdict, never an error.

    Raises
    ------
    InputUnusable
        If a source cannot be used, a picture does not fit the calibration, the laser-off pictures
        do not pair with the others, or the earlier check cannot be compared.
    RecordingUnreadable
        If a recording is damaged.
    """
    if not sources:
        raise InputUnusable("no SOURCE given; give recordings, pictures or folders")
    earlier = None if since is None else _place_then(since, calibration, piece)
    stripes = stripes_of(
        sources,
        calibration.sensor,
        calibration.camera.model(),
        laser_off=laser_off,
        progress=progress,
    )
    seen = [(one.name, one.seen) for one in stripes if isinstance(one.seen, StripePoints)]
    judged = judge_piece(
        seen,
        calibration.laser_sensor(),
        piece,
        limit_mm=limit_mm,
        temperature_c=temperature_c,
        earlier=earlier,
    )
    return piece_check(
        judged,
        piece,
        created=datetime.now(UTC),
        software=SOFTWARE,
        sensor=calibration.sensor,
        calibration=calibration.fingerprint,
        limit_mm=limit_mm,
        temperature_c=temperature_c,
    )


def _place_then(
    since: PieceCheck, calibration: CalibrationDocument, piece: Piece
) -> PiecePlace | None:
    if (since.piece, since.serial) != (piece.name, piece.serial):
        raise InputUnusable(
            f"the earlier check is of piece {since.piece} {since.serial}, not of {piece.name} "
            f"{piece.serial}; give a check of the same piece"
        )
    if since.calibration != calibration.fingerprint:
        raise InputUnusable(
            "the earlier check was made with another calibration, on whose sheet places are "
            "others; give a check by this one, or none"
        )
    return since.place
