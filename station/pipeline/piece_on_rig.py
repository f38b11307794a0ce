"""A reference piece in the sheets of several sensors: does their rig hold, where do they stand."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from measure import Piece, RigFromPiece, judge_piece_on_rig, rig_from_piece
from station.documents import Gate, PieceCheck, RigDocument, piece_check, sensors_of
from station.pipeline.calibrate import fingerprints
from station.pipeline.piece_order import PieceOrder
from station.pipeline.piece_shots import PieceShots, depths_mm, piece_shots
from station.pipeline.quality import LARGEST_SHEET_SIGMA_MM, at_most
from station.pipeline.rig_parts import side_of, surveyed
from station.progress import Progress, silent
from station.software import SOFTWARE

FEWEST_SHOTS = 4.0
"""Slants to both sides about both axes."""
LARGEST_RMS_MM = 0.05
"""Speckle scatters the points of a good stripe by a third of this."""
_LOCATING_PART = 0.8
"""Of the progress: finding stripes in pictures takes most of the time."""


def check_piece_on_rig(
    sources: Sequence[Path],
    rig: RigDocument,
    piece: Piece,
    *,
    laser_off: Sequence[Path] = (),
    limit_mm: float | None = None,
    temperature_c: float | None = None,
    progress: Progress = silent,
) -> PieceCheck:
    """Measure a piece with all sensors of a rig, and say whether they stand where the rig has them.

    Parameters
    ----------
    sources
        One of each sensor: recordings by what they say, others in the order of the rig's sensors.
        Pictures of one placing are told by their times, else by alike names, else by their order.
    rig
        The rig under test.
    piece
        What its certificate says.
    laser_off
        The same with the laser off, one source of each sensor.
    limit_mm, temperature_c
        As for `measure.judge_piece_on_rig`.
    progress
        Told how far it is.

    Returns
    -------
    PieceCheck
        A document to keep; that nothing could be said is a verdict, never an error.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or pictures, laser-off pictures and sensors do not pair.
    RecordingUnreadable
        If a recording is damaged.
    """
    known = rig.to_rig()
    sensors = {each.name: each.sensor for each in known.sensors}
    shots, _ = piece_shots(sources, sensors, laser_off=laser_off, progress=progress)
    judged = judge_piece_on_rig(shots, known, piece, limit_mm=limit_mm, temperature_c=temperature_c)
    return piece_check(
        judged,
        piece,
        created=datetime.now(UTC),
        software=SOFTWARE,
        sensor=rig.rig,
        calibration=rig.fingerprint,
        limit_mm=limit_mm,
        temperature_c=temperature_c,
    )


def calibrate_rig_on_piece(
    sources: Sequence[Path],
    order: PieceOrder,
    piece: Piece,
    *,
    laser_off: Sequence[Path] = (),
    progress: Progress = silent,
) -> RigDocument:
    """Calibrate a rig from pictures of one reference piece in several placings.

    Parameters
    ----------
    sources, laser_off
        As for `check_piece_on_rig`; others than recordings in the order of the calibrations.
    order
        What the rig is made of.
    piece
        What its certificate says.
    progress
        Told how far it is.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or pictures and sensors do not pair.
    RecordingUnreadable
        If a recording is damaged.
    CalibError
        If the placings do not determine the rig.
    """
    shots, missing = piece_shots(
        sources,
        order.sensors,
        laser_off=laser_off,
        progress=lambda part, what: progress(_LOCATING_PART * part, what),
    )
    progress(_LOCATING_PART, "solving the rig")
    answer = rig_from_piece(
        shots,
        order.sensors,
        piece,
        anchor=order.anchoring.sensor,
        start=order.start_poses(),
        sigma_start_mm=order.sigma_start_mm,
        sigma_start_rad=order.sigma_start_rad,
        temperature_c=order.temperature_c,
    )
    progress(1.0, "done")
    return _document(answer, order, piece, shots, missing, sources)


def _document(
    answer: RigFromPiece,
    order: PieceOrder,
    piece: Piece,
    shots: PieceShots,
    missing: Mapping[str, str],
    sources: Sequence[Path],
) -> RigDocument:
    anchoring = order.anchoring
    rig, survey = surveyed(
        answer.rig,
        anchoring,
        sigma_vibration_mm=order.sigma_vibration_mm,
        sigma_vibration_rad=order.sigma_vibration_rad,
    )
    return RigDocument(
        rig=order.rig,
        side=order.side or side_of(anchoring),
        created=datetime.now(UTC),
        software=SOFTWARE,
        method="piece",
        anchor=anchoring.sensor,
        sensors=sensors_of(
            rig,
            {each.sensor: each.fingerprint for each in order.calibrations},
            depths_mm(order.sensors, shots, answer.rms_mm),
        ),
        covariance=rig.covariance.tolist(),
        survey=survey,
        rms=None,
        quality=_gates(answer),
        options={
            "piece": piece.name,
            "serial": piece.serial,
            "sigma_start_mm": order.sigma_start_mm,
            "sigma_start_rad": order.sigma_start_rad,
            "temperature_c": order.temperature_c,
        },
        inputs=fingerprints(sources),
        warnings=answer.warnings,
        left_out={**missing, **answer.left_out},
    )


def _gates(answer: RigFromPiece) -> dict[str, Gate]:
    used = float(len(answer.rms_mm))
    in_section = [one.sigma_mm for one in answer.motions if one.in_section]
    return {
        "shots_used": Gate(value=used, limit=FEWEST_SHOTS, passed=used >= FEWEST_SHOTS),
        "piece_rms_mm": at_most(
            float(np.sqrt(np.mean(np.square(list(answer.rms_mm.values()))))), LARGEST_RMS_MM
        ),
        "section_sigma_mm": at_most(max(in_section), LARGEST_SHEET_SIGMA_MM),
    }
