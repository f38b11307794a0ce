"""What a person is told who takes calibration pictures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    CalibError,
    Calibration,
    Coverage,
    FloatArray,
    LaserSensor,
    RigidTransform,
    Scatter,
    SheetDoubt,
    Target,
    View,
    calibrate,
    field_of,
    information_of,
    next_pose,
    standing_of,
    start_pose,
)
from station.documents import CalibrationDocument
from station.guiding.enough import Criterion, Demand, Demands
from station.guiding.watch import SessionSoFar
from station.pipeline import working_pixels

_MOST_DRAWN = 200
_FEWEST_TO_SOLVE = 3


@dataclass(frozen=True, slots=True)
class PoseSeen:
    """What one pose showed.

    Attributes
    ----------
    why
        Why the target was not found; empty where it was.
    dots, dots_of
        Of the target's points, how many were found.
    stripe
        Points of the stripe on the target; 0 where it does not lie on it.
    dots_px, stripe_px
        Where they are in the picture, rounded, at most 200 of the stripe's.
    tilt_deg, near_edge_deg, depth_mm
        How the target stood, see `calib.Standing`; None where no camera tells it yet.
    """

    number: int
    why: str
    dots: int
    dots_of: int
    stripe: int
    dots_px: tuple[tuple[float, float], ...] = ()
    stripe_px: tuple[tuple[float, float], ...] = ()
    tilt_deg: float | None = None
    near_edge_deg: float | None = None
    depth_mm: float | None = None


@dataclass(frozen=True, slots=True)
class Wanted:
    """The pose that is worth most now.

    Attributes
    ----------
    across, down
        Where in the picture its middle is then seen, 0 to 1.
    tilt_deg, near_edge_deg, depth_mm
        How the target is to be held.
    falls_to
        What the sheet's standard deviation over the field falls to, part of the present one.
    """

    across: float
    down: float
    tilt_deg: float
    near_edge_deg: float
    depth_mm: float
    falls_to: float


@dataclass(frozen=True, slots=True)
class Guidance:
    """All that is told.

    Attributes
    ----------
    poses
        In the order they were taken.
    size_px
        Width and height of the pictures; None before the first.
    criteria
        What is asked of them together.
    unsolved
        Why no trial solve gives a sensor; empty where one does.
    dots_on_cells, wanted_cells
        The field by cells, row by row; None where it is not known yet.
    next
        None where no sensor is known yet to tell it by, or no pose shows the whole target.
    """

    poses: tuple[PoseSeen, ...]
    size_px: tuple[int, int] | None
    criteria: tuple[Criterion, ...]
    unsolved: str
    dots_on_cells: tuple[tuple[int, ...], ...] | None
    wanted_cells: tuple[tuple[bool, ...], ...] | None
    next: Wanted | None

    @property
    def enough(self) -> bool:
        """Whether all criteria are met."""
        return all(each.met for each in self.criteria)


def guidance_of(
    so_far: SessionSoFar,
    target: Target,
    demands: Demands,
    present: CalibrationDocument | None = None,
) -> Guidance:
    """Judge what a session has shown so far, and say what comes next.

    Parameters
    ----------
    present
        The calibration in force: it tells the field, and how targets stand before three pictures
        do; the pictures alone decide what is enough.
    """
    trial, unsolved = _trial(so_far, target)
    sensor = trial.sensor if trial is not None else _of(present, so_far)
    poses = _poses(so_far.views, target, sensor)
    field_px = np.empty((0, 2)) if sensor is None else _field_px(sensor, poses, target, present)
    coverage = None if sensor is None else _coverage(so_far, sensor, field_px)
    crossed = sum(view.stripe is not None for view in so_far.views)
    criteria = demands.criteria(crossed, trial, coverage, field_px)
    return Guidance(
        poses=_poses_seen(so_far, target, poses),
        size_px=so_far.size_px,
        criteria=criteria,
        unsolved=unsolved,
        dots_on_cells=None if coverage is None else tuple(map(tuple, coverage.dots.tolist())),
        wanted_cells=None if coverage is None else tuple(map(tuple, coverage.wanted.tolist())),
        next=None
        if sensor is None or coverage is None
        else _next(sensor, field_px, so_far.views, poses, target, _missing(coverage, criteria)),
    )


def _trial(so_far: SessionSoFar, target: Target) -> tuple[Calibration | None, str]:
    """Solve as the worker will; return the answer, or why there is none."""
    if so_far.size_px is None or len(so_far.views) < _FEWEST_TO_SOLVE:
        return None, ""
    width, height = so_far.size_px
    try:
        return calibrate(so_far.views, target, width=width, height=height), ""
    except CalibError as error:
        return None, str(error)


def _of(present: CalibrationDocument | None, so_far: SessionSoFar) -> LaserSensor | None:
    """Return the sensor in force, where its pictures are as large as those of the session."""
    if present is None:
        return None
    sensor = present.laser_sensor()
    fits = so_far.size_px in {None, (sensor.camera.width, sensor.camera.height)}
    return sensor if fits else None


def _poses(
    views: Sequence[View], target: Target, sensor: LaserSensor | None
) -> dict[str, RigidTransform]:
    """Return how the targets stood, by the view's name, as far as it can be told."""
    found: dict[str, RigidTransform] = {}
    if sensor is None:
        return found
    for view in views:
        try:
            found[view.name] = start_pose(view, target, sensor.camera)
        except CalibError:  # a picture that the solve would leave out as well
            continue
    return found


def _field_px(
    sensor: LaserSensor,
    poses: dict[str, RigidTransform],
    target: Target,
    present: CalibrationDocument | None,
) -> FloatArray:
    """Return where the sensor measures: where it did, else between the depths shown."""
    if present is not None:
        size_px = present.camera.width, present.camera.height
        if size_px == (sensor.camera.width, sensor.camera.height):
            return working_pixels([present])
    depths = [pose.apply(target.points_mm)[:, 2] for pose in poses.values()]
    every = np.concatenate([np.empty(0), *depths])
    reach = (float(every.min()), float(every.max())) if len(every) else (0.0, np.inf)
    return field_of(sensor, reach)


def _coverage(so_far: SessionSoFar, sensor: LaserSensor, field_px: FloatArray) -> Coverage:
    dots_px = np.concatenate([
        np.empty((0, 2)),
        *(view.points.centre_px for view in so_far.views),
    ])
    return Coverage.of(dots_px, field_px, width=sensor.camera.width, height=sensor.camera.height)


def _missing(coverage: Coverage, criteria: Sequence[Criterion]) -> Coverage | None:
    """Return the coverage where it is what all others wait for."""
    open_ones = [each.demand for each in criteria if not each.met]
    return coverage if open_ones == [Demand.COVERED] else None


def _next(
    sensor: LaserSensor,
    field_px: FloatArray,
    views: Sequence[View],
    poses: dict[str, RigidTransform],
    target: Target,
    coverage: Coverage | None,
) -> Wanted | None:
    told = [
        information_of(view, target, sensor, poses[view.name])
        for view in views
        if view.name in poses
    ]
    doubt = SheetDoubt.of(sensor, field_px, told)
    found = next_pose(doubt, target, Scatter.of(tuple(views)), coverage)
    if found is None:
        return None
    u, v = found.centre_px
    return Wanted(
        across=u / (sensor.camera.width - 1),
        down=v / (sensor.camera.height - 1),
        tilt_deg=found.standing.tilt_deg,
        near_edge_deg=found.standing.near_edge_deg,
        depth_mm=found.standing.depth_mm,
        falls_to=found.sigma_mm / doubt.sigma_mm(),
    )


def _poses_seen(
    so_far: SessionSoFar, target: Target, poses: dict[str, RigidTransform]
) -> tuple[PoseSeen, ...]:
    count = target.rows * target.cols
    return tuple(
        PoseSeen(number, each, 0, count, 0)
        if isinstance(each, str)
        else _pose_seen(number, each, target, poses.get(each.name))
        for number, each in enumerate(so_far.seen, start=1)
    )


def _pose_seen(
    number: int, view: View, target: Target, cam_from_board: RigidTransform | None
) -> PoseSeen:
    stripe_px = np.empty((0, 2)) if view.stripe is None else view.stripe.centre_px
    every = -(-len(stripe_px) // _MOST_DRAWN) or 1
    standing = None if cam_from_board is None else standing_of(cam_from_board, target)
    return PoseSeen(
        number=number,
        why="",
        dots=len(view.points),
        dots_of=target.rows * target.cols,
        stripe=len(stripe_px),
        dots_px=_rounded(view.points.centre_px),
        stripe_px=_rounded(stripe_px[::every]),
        tilt_deg=None if standing is None else standing.tilt_deg,
        near_edge_deg=None if standing is None else standing.near_edge_deg,
        depth_mm=None if standing is None else standing.depth_mm,
    )


def _rounded(pixels_px: FloatArray) -> tuple[tuple[float, float], ...]:
    return tuple((u, v) for u, v in np.round(pixels_px, 1).tolist())
