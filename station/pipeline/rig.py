"""From pictures of a rigid target to where the sensors of a rig stand to each other."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from calib import (
    FloatArray,
    LaserSensor,
    RigCalibration,
    RigShowing,
    Target,
    View,
    calibrate_rig,
)
from measure import Side
from station.documents import (
    BOARD_SIGMA_MM,
    CalibrationDocument,
    Gate,
    InputFile,
    RigDocument,
    RmsDocument,
    rig_points_csv,
    sensors_of,
)
from station.errors import InputUnusable
from station.pipeline.calibrate import fingerprints
from station.pipeline.observe_showings import observe_showings
from station.pipeline.quality import LARGEST_SHEET_SIGMA_MM, LARGEST_SIGMA_SCALE, at_most
from station.pipeline.rig_parts import anchoring_of, ensure_rig, side_of, surveyed
from station.pipeline.rig_sources import sources_by_sensor
from station.pipeline.showings import Showing, missing_in, showings_of
from station.progress import Progress, silent
from station.software import SOFTWARE

FEWEST_SHOWINGS = 3.0
"""Three fix the poses with nothing to check them by."""
_ONE_BOARD = "board"
_NEXT_TO_NOTHING = 1e4
"""Factor on a covariance that leaves parameters to the pictures, and those held held."""


@dataclass(frozen=True, slots=True)
class RigOrder:
    """What a rig is made of, and how it is to be solved.

    Attributes
    ----------
    rig
        Its name.
    calibrations
        Of its sensors, in order.
    boards
        The board that each sensor sees, in the same order; one for all where they are alike.
    same_board
        Whether it is one board that all of them see, not one each.
    board_sigma_mm
        How far each dot is from its place on the board.
    anchor
        The sensor that carries the frame; the first with a mounting where None, else the first.
    side
        Of the train; by the anchor's mounting where None.
    sigma_vibration_mm, sigma_vibration_rad
        As of `measure.Survey`, where they are known.

    Raises
    ------
    InputUnusable
        If calibrations and boards do not make a rig.
    """

    rig: str
    calibrations: tuple[CalibrationDocument, ...]
    boards: tuple[Target, ...]
    same_board: bool = False
    board_sigma_mm: float = BOARD_SIGMA_MM
    anchor: str | None = None
    side: Side | None = None
    sigma_vibration_mm: float | None = None
    sigma_vibration_rad: float | None = None

    def __post_init__(self) -> None:
        ensure_rig(self.calibrations, self.anchor)
        names = [each.sensor for each in self.calibrations]
        allowed = {1} if self.same_board else {1, len(names)}
        if len(self.boards) not in allowed:
            raise InputUnusable(
                f"{len(self.boards)} targets for {len(names)} sensors; allowed: one for all"
                + ("" if self.same_board else ", or one for each in the order of the calibrations")
            )

    @property
    def sensors(self) -> dict[str, LaserSensor]:
        """The sensors, by name."""
        return {each.sensor: each.laser_sensor() for each in self.calibrations}

    @property
    def board_of(self) -> dict[str, Target]:
        """The board that each sensor sees."""
        names = [each.sensor for each in self.calibrations]
        boards = self.boards if len(self.boards) > 1 else self.boards * len(names)
        return dict(zip(names, boards, strict=True))

    def board_name(self, sensor: str) -> str:
        """Return what the board that a sensor sees is called."""
        return _ONE_BOARD if self.same_board else f"board of {sensor}"

    @property
    def anchoring(self) -> CalibrationDocument:
        """The calibration of the anchor."""
        return anchoring_of(self.calibrations, self.anchor)

    def options(self) -> dict[str, object]:
        """Return what was wished, as the document keeps it."""
        return {
            "targets": {name: str(board) for name, board in self.board_of.items()},
            "same_board": self.same_board,
            "board_sigma_mm": self.board_sigma_mm,
        }


@dataclass(frozen=True, slots=True)
class RigOutcome:
    """A calibrated rig and its points: the texts of rig.json and of a points.csv of each sensor."""

    document: RigDocument
    points_csv: Mapping[str, str]


def calibrate_rig_sources(
    sources: Sequence[Path], order: RigOrder, *, progress: Progress = silent
) -> RigOutcome:
    """Calibrate a rig from recordings, folders of pictures or points.csv, one of each sensor.

    Pictures of one showing are told by their times, else by alike names, else by their order. A
    showing that one sensor has no picture of still serves the others.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or pictures and sensors do not pair.
    RecordingUnreadable
        If a recording is damaged.
    CalibError
        If the pictures do not determine the rig.
    """
    chosen = sources_by_sensor(sources, list(order.sensors))
    poses = observe_showings(
        chosen,
        order.board_of,
        order.sensors,
        progress=lambda part, what: progress(0.9 * part, what),
    )
    showings = showings_of(poses)
    progress(0.9, "solving the rig")
    inputs = fingerprints(list(chosen.values()))
    known, seen_before = _known_before(order.calibrations, inputs)
    answer = calibrate_rig(
        [RigShowing(name, _views(showing, order)) for name, showing in showings],
        known,
        {order.board_name(sensor): board for sensor, board in order.board_of.items()},
        anchor=order.anchoring.sensor,
        sigma_board_mm=order.board_sigma_mm,
    )
    progress(1.0, "done")
    unseen = (pose for own in poses.values() for pose in own)
    left_out = {
        **missing_in(showings, list(order.sensors)),
        **{pose.name: pose.seen for pose in unseen if isinstance(pose.seen, str)},
        **answer.left_out,
    }
    document = _document(answer, order, showings, left_out, inputs)
    document = document.model_copy(update={"warnings": (*document.warnings, *seen_before)})
    return RigOutcome(document, rig_points_csv(answer))


def _known_before(
    calibrations: Sequence[CalibrationDocument], inputs: Sequence[InputFile]
) -> tuple[dict[str, LaserSensor], list[str]]:
    """Return what was known of the sensors without these pictures, and what to say of it.

    A calibration that rests on the same pictures is where to start, and no knowledge besides:
    taken for that, each picture would count twice.
    """
    these = {each.sha256 for each in inputs}
    known, said = {}, []
    for each in calibrations:
        sensor = each.laser_sensor()
        if these & {one.sha256 for one in each.inputs}:
            sensor = replace(sensor, covariance=sensor.covariance * _NEXT_TO_NOTHING)
            said.append(
                f"the calibration of {each.sensor} rests on the same pictures: the rig takes it "
                "for a start, not for knowledge"
            )
        known[each.sensor] = sensor
    return known, said


def _views(showing: Showing, order: RigOrder) -> dict[str, tuple[str, View]]:
    return {
        sensor: (order.board_name(sensor), pose.seen)
        for sensor, pose in showing.items()
        if isinstance(pose.seen, View)
    }


def _document(
    answer: RigCalibration,
    order: RigOrder,
    showings: Sequence[tuple[str, Showing]],
    left_out: dict[str, str],
    inputs: tuple[InputFile, ...],
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
        method="board" if order.same_board else "boards",
        anchor=anchoring.sensor,
        sensors=sensors_of(
            rig,
            {each.sensor: each.fingerprint for each in order.calibrations},
            _depths_mm(answer, showings),
        ),
        covariance=rig.covariance.tolist(),
        survey=survey,
        rms=RmsDocument(dots_px=answer.rms_dots_px, stripe_px=answer.rms_stripe_px),
        quality=_gates(answer, showings),
        options=order.options(),
        inputs=inputs,
        warnings=answer.warnings,
        left_out=left_out,
    )


def _gates(answer: RigCalibration, showings: Sequence[tuple[str, Showing]]) -> dict[str, Gate]:
    used = sum(name not in answer.left_out for name, _ in showings)
    fits = answer.fits.values()
    placing_mm = max(reach.sigma_mm for reach in answer.reach.values())
    return {
        "showings_used": Gate(value=used, limit=FEWEST_SHOWINGS, passed=used >= FEWEST_SHOWINGS),
        "dots_sigma_scale": at_most(max(fit.sigma_scale_dots for fit in fits), LARGEST_SIGMA_SCALE),
        "stripe_sigma_scale": at_most(
            max(fit.sigma_scale_stripe for fit in fits), LARGEST_SIGMA_SCALE
        ),
        "placing_sigma_mm": at_most(placing_mm, LARGEST_SHEET_SIGMA_MM),
    }


def _stripes_px(sensor: str, showings: Sequence[tuple[str, Showing]]) -> FloatArray:
    seen = [showing[sensor].seen for _, showing in showings if sensor in showing]
    stripes = [view.stripe for view in seen if isinstance(view, View)]
    return np.concatenate([
        np.empty((0, 2)),
        *(each.centre_px for each in stripes if each is not None),
    ])


def _depths_mm(
    answer: RigCalibration, showings: Sequence[tuple[str, Showing]]
) -> dict[str, tuple[float, float]]:
    depths = {}
    for each in answer.rig.sensors:
        depth = each.sensor.locate(_stripes_px(each.name, showings))[:, 2]
        if np.isfinite(depth).any():
            depths[each.name] = (float(np.nanmin(depth)), float(np.nanmax(depth)))
    return depths
