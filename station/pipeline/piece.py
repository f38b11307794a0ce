"""Whether a sensor still tells the truth: pictures of a piece against its certificate."""

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np

from calib import Picture, PixelNoise, StripePoints, locate_stripe
from measure import Piece, PiecePlace, judge_piece
from station.documents import CalibrationDocument, PieceCheck, piece_check
from station.errors import InputUnusable
from station.pipeline.cores import map_on_all_cores
from station.pipeline.frames import Frame, alike, count_frames, read_frames
from station.progress import Progress, silent
from station.software import SOFTWARE

_LOCATE_S = 0.1
_Task = tuple[Picture, Picture | None]


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
    total, names = count_frames(sources), []

    def tasks() -> Iterator[_Task]:
        for frame, dark in _paired(sources, laser_off):
            _check(frame, calibration)
            names.append(frame.name)
            yield frame.picture, dark

    stripes: Iterator[StripePoints] = map_on_all_cores(
        _locate, tasks(), count=total, seconds_each=_LOCATE_S
    )
    seen: list[tuple[str, StripePoints]] = []
    for done, stripe in enumerate(stripes):
        progress((done + 1) / total, f"picture {done + 1} of {total}")
        seen.append((names[done], stripe))
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


def _paired(
    sources: Sequence[Path], laser_off: Sequence[Path]
) -> Iterator[tuple[Frame, Picture | None]]:
    if not laser_off:
        for frame in read_frames(sources):
            yield frame, None
        return
    total, darks = count_frames(sources), count_frames(laser_off)
    if darks not in {1, total}:
        raise InputUnusable(
            f"{darks} laser-off pictures for {total} pictures; allowed: one for all, or one for "
            "each in the same order"
        )
    dark_frames = read_frames(laser_off)
    dark = next(dark_frames)
    for place, frame in enumerate(read_frames(sources)):
        if place and darks > 1:
            dark = next(dark_frames)
        yield frame, alike(dark, frame).picture


def _check(frame: Frame, calibration: CalibrationDocument) -> None:
    height, width = frame.picture.shape
    camera = calibration.camera
    if (width, height) != (camera.width, camera.height):
        raise InputUnusable(
            f"{frame.name} is {width} x {height} px but the calibration is of {camera.width} x "
            f"{camera.height}; give pictures of the same camera"
        )
    if frame.sensor not in {None, calibration.sensor}:
        raise InputUnusable(
            f"{frame.name} is of sensor {frame.sensor} but the calibration is of "
            f"{calibration.sensor}; give the calibration of that sensor"
        )


def _locate(task: _Task) -> StripePoints:
    picture, dark = task
    if dark is None:
        return locate_stripe(picture)
    of_dark = PixelNoise.from_picture(dark)
    lit = np.asarray(cv2.subtract(picture, dark), dtype=np.uint8)
    # The noise of both pictures is in the difference.
    return locate_stripe(lit, noise=PixelNoise(2.0 * of_dark.floor, of_dark.gain))
