"""A reference piece in the sheets of several sensors: does their rig hold, where do they stand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from calib import LaserSensor, RigidTransform, StripePoints
from measure import Piece, RigFromPiece, Side, judge_piece_on_rig, rig_from_piece
from station.documents import (
    CalibrationDocument,
    Gate,
    PieceCheck,
    RigDocument,
    piece_check,
    sensors_of,
)
from station.errors import InputUnusable
from station.pipeline.calibrate import fingerprints
from station.pipeline.piece_stripes import stripes_of
from station.pipeline.quality import LARGEST_SHEET_SIGMA_MM, at_most
from station.pipeline.rig_parts import anchoring_of, ensure_rig, side_of, surveyed
from station.pipeline.rig_sources import sources_by_sensor
from station.pipeline.showings import missing_in, showings_of
from station.progress import Progress, silent
from station.software import SOFTWARE

FEWEST_SHOTS = 4.0
"""Slants to both sides about both axes."""
LARGEST_RMS_MM = 0.05
"""Speckle scatters the points of a good stripe by a third of this."""

_Shots = list[tuple[str, dict[str, StripePoints]]]


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
    shots, _ = _shots_of(sources, sensors, laser_off, progress)
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


@dataclass(frozen=True, slots=True)
class PieceOrder:
    """What a rig is made of, and what is known of it before a piece is shown.

    Attributes
    ----------
    rig
        Its name.
    calibrations
        Of its sensors, in order.
    start
        An earlier rig of these sensors, from which the search starts; None starts from the
        mountings in their calibrations.
    sigma_start_mm, sigma_start_rad
        How well that is known; None: it fills nothing that the piece leaves open.
    anchor
        The sensor that carries the frame; the first with a mounting where None, else the first.
    side
        Of the train; by the anchor's mounting where None.
    temperature_c
        Of the piece; None counts its warmth as unknown.
    sigma_vibration_mm, sigma_vibration_rad
        As of `measure.Survey`, where they are known.

    Raises
    ------
    InputUnusable
        If the calibrations make no rig, or nothing says where the sensors stand.
    """

    rig: str
    calibrations: tuple[CalibrationDocument, ...]
    start: RigDocument | None = None
    sigma_start_mm: float | None = None
    sigma_start_rad: float | None = None
    anchor: str | None = None
    side: Side | None = None
    temperature_c: float | None = None
    sigma_vibration_mm: float | None = None
    sigma_vibration_rad: float | None = None

    def __post_init__(self) -> None:
        ensure_rig(self.calibrations, self.anchor)
        for name in ("sigma_start_mm", "sigma_start_rad"):
            sigma = getattr(self, name)
            if sigma is not None and not 0.0 < sigma < float("inf"):
                raise InputUnusable(
                    f"{name} is {sigma:g}; allowed: more than 0, or none where nothing is known"
                )
        placed = (
            {each.sensor for each in self.calibrations if each.mounting is not None}
            if self.start is None
            else set(self.start.names)
        )
        missing = [each.sensor for each in self.calibrations if each.sensor not in placed]
        if missing:
            raise InputUnusable(
                f"nothing says where {missing[0]} stands; give calibrations with a mounting, or "
                "an earlier rig of these sensors to start from"
            )

    @property
    def sensors(self) -> dict[str, LaserSensor]:
        """The sensors, by name."""
        return {each.sensor: each.laser_sensor() for each in self.calibrations}

    @property
    def anchoring(self) -> CalibrationDocument:
        """The calibration of the anchor."""
        return anchoring_of(self.calibrations, self.anchor)

    def start_poses(self) -> dict[str, RigidTransform]:
        """Return rig_from_camera of each sensor where the search starts."""
        if self.start is not None:
            return {each.name: each.rig_from_camera for each in self.start.to_rig().sensors}
        return {
            each.sensor: each.mounting.rig_from_camera()
            for each in self.calibrations
            if each.mounting is not None
        }


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
    shots, missing = _shots_of(
        sources, order.sensors, laser_off, lambda part, what: progress(0.8 * part, what)
    )
    progress(0.8, "solving the rig")
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


def _shots_of(
    sources: Sequence[Path],
    sensors: Mapping[str, LaserSensor],
    laser_off: Sequence[Path],
    progress: Progress,
) -> tuple[_Shots, dict[str, str]]:
    """Return the stripes of each placing by sensor, and which pictures are missing."""
    names = list(sensors)
    chosen = sources_by_sensor(sources, names)
    dark = sources_by_sensor(laser_off, names) if laser_off else {}
    seen = {}
    for place, (sensor, source) in enumerate(chosen.items()):

        def report(done: float, what: str, first: int = place, name: str = sensor) -> None:
            progress((first + done) / len(chosen), f"{name}: {what}")

        seen[sensor] = list(
            stripes_of(
                [source],
                sensor,
                sensors[sensor].camera,
                laser_off=[dark[sensor]] if dark else (),
                progress=report,
            )
        )
    showings = showings_of(seen)
    shots = [
        (
            name,
            {
                sensor: pose.seen
                for sensor, pose in showing.items()
                if isinstance(pose.seen, StripePoints)
            },
        )
        for name, showing in showings
    ]
    return shots, missing_in(showings, names)


def _document(
    answer: RigFromPiece,
    order: PieceOrder,
    piece: Piece,
    shots: _Shots,
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
            _depths_mm(order.sensors, shots, answer.rms_mm),
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


def _depths_mm(
    sensors: Mapping[str, LaserSensor], shots: _Shots, used: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return how far before each camera the middle nine tenths of its stripes lay."""
    depths = {}
    for name, sensor in sensors.items():
        seen = [shot[name].centre_px for at, shot in shots if at in used and name in shot]
        depth = sensor.locate(np.concatenate(seen))[:, 2]
        near, far = np.nanpercentile(depth, [5.0, 95.0])
        depths[name] = (float(near), float(far))
    return depths
