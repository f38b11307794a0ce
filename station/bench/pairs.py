"""What several exposures of each pose add to a calibration, the camera known and solved as well."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import (
    CalibError,
    CameraModel,
    Cause,
    FloatArray,
    LaserSensor,
    RigidTransform,
    Target,
    TargetPoints,
    View,
    calibrate,
    sheet_difference_mm,
)
from station.demo import working_field_px
from station.pipeline import Exposure, PoseShot, map_on_all_cores, observe_group
from station.progress import Progress
from station.scenes import Light, TargetScene, paper_sensor, target_scenes
from station.tables import Table, Value

TARGET = Target.parse("dots:7x8:12:d=6")
_DOT_RADIUS_MM = 3.0
_LONG, _SHORT = 1.0, 0.2
_TAKEN = ((_LONG, True), (_SHORT, True), (_LONG, False), (_SHORT, False))
"""(exposure, laser) of the shots of a pose."""
_SETS = {
    "long": _TAKEN[:1],
    "short": _TAKEN[1:2],
    "long and short": _TAKEN[:2],
    "long and short, laser on and off": _TAKEN,
}
_LONG_US = 10_000.0
_RENDER_AND_OBSERVE_S = 1.6
_SPOKES = 180
_Task = tuple[TargetScene, int]


@dataclass(frozen=True, slots=True, eq=False)
class SeenPose:
    """A pose, and what each set of its shots shows; None where that is no target."""

    cam_from_board: RigidTransform
    views: dict[str, View | None]


def bench_pairs(progress: Progress, *, seeds: int = 8, poses: int = 20) -> Table:
    """Calibrate from one exposure of each pose, from two, and from two with the laser on and off.

    Parameters
    ----------
    progress
        Told where the bench is.
    seeds
        Sessions, of other poses and noise each; the errors are root mean squares over them.
    poses
        Of a session, in all seven lights by turns.
    """
    sensor = paper_sensor()
    sessions = []
    for seed in range(1, seeds + 1):
        progress((seed - 1) / seeds, f"session {seed} of {seeds}")
        sessions.append(observe_session(sensor, seed=seed, poses=poses))
    rows = [_row(name, sessions, sensor) for name in _SETS]
    note = (
        f"{seeds} sessions of {poses} poses of {TARGET} in the seven lights by turns; the short "
        f"exposure is {_SHORT:g} of the long. Sheet errors are RMS over the field at working "
        "distance and over the sessions; beside them what the covariance told. Where the camera is "
        "solved one session's error is little more than one draw: of few sessions it tells nothing."
    )
    return Table("Exposures of a pose", rows, (note,))


def observe_session(sensor: LaserSensor, *, seed: int, poses: int) -> list[SeenPose]:
    """Render the poses of a session and observe each by every set of its shots."""
    rng = np.random.default_rng([seed, poses])
    lights = [list(Light)[place % len(Light)] for place in range(poses)]
    scenes = target_scenes(rng, sensor, TARGET, lights)
    noise_seeds = rng.integers(2**32, size=poses).tolist()
    tasks = list(zip(scenes, noise_seeds, strict=True))
    return list(map_on_all_cores(_observe, tasks, count=poses, seconds_each=_RENDER_AND_OBSERVE_S))


def _observe(task: _Task) -> SeenPose:
    scene, noise_seed = task
    rng = np.random.default_rng(noise_seed)
    light = {True: scene.light_counts(), False: replace(scene, laser_on=False).light_counts()}
    shots = {
        taken: PoseShot(
            f"exposure {taken[0]:g}, laser {taken[1]}",
            scene.physics.detector.expose(light[taken[1]], rng, taken[0]),
            Exposure(taken[0] * _LONG_US, 0.0, laser=taken[1], group=1),
        )
        for taken in _TAKEN
    }
    views = {name: _seen([shots[one] for one in taken]) for name, taken in _SETS.items()}
    return SeenPose(scene.cam_from_board, views)


def _seen(shots: Sequence[PoseShot]) -> View | None:
    try:
        return observe_group(shots, TARGET)
    except CalibError:
        return None


def _row(
    name: str, sessions: Sequence[Sequence[SeenPose]], sensor: LaserSensor
) -> dict[str, Value]:
    views = [[view for pose in one if (view := pose.views[name]) is not None] for one in sessions]
    off_sigmas = np.concatenate([
        dot_errors_sigmas(view.points, pose.cam_from_board, sensor.camera)
        for one in sessions
        for pose in one
        if (view := pose.views[name]) is not None
    ])
    row: dict[str, Value] = {
        "exposures": name,
        "poses seen": sum(map(len, views)) / len(views),
        "dots' errors over sigma": _rms(off_sigmas),
    }
    for what, camera in (("known", sensor.camera), ("solved", None)):
        errors = [sheet_error_and_told_mm(one, sensor, camera) for one in views]
        error_mm, told_mm = np.sqrt(np.mean(np.square(errors), axis=0))
        row[f"camera {what}, mm"] = float(error_mm) if np.isfinite(error_mm) else "refused"
        row[f"told, {what}"] = float(told_mm) if np.isfinite(told_mm) else "refused"
    return row


def dot_errors_sigmas(
    points: TargetPoints, cam_from_board: RigidTransform, camera: CameraModel
) -> FloatArray:
    """Return how far the dots nothing speaks against are off the truth, in sigmas, shape (2N,)."""
    clear = np.array([cause is Cause.NONE for cause in points.cause])
    true_px = true_centres_px(points.points_mm(TARGET.pitch_mm), cam_from_board, camera)
    return np.asarray(((points.centre_px - true_px) / points.sigma_px)[clear].ravel())


def true_centres_px(
    points_mm: FloatArray, cam_from_board: RigidTransform, camera: CameraModel
) -> FloatArray:
    """Return the centroids of the dots' pictures, shape (N, 2): of their outlines as polygons."""
    angle = 2.0 * np.pi * np.arange(_SPOKES) / _SPOKES
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(_SPOKES)])
    outline_mm = points_mm[:, None] + _DOT_RADIUS_MM * circle
    outline_px = camera.project(cam_from_board.apply(outline_mm.reshape(-1, 3)))
    corner = outline_px.reshape(len(points_mm), _SPOKES, 2)
    middle = corner.mean(axis=1, keepdims=True)
    one, other = corner - middle, np.roll(corner, -1, axis=1) - middle
    twice_area = one[:, :, 0] * other[:, :, 1] - one[:, :, 1] * other[:, :, 0]
    moment = ((one + other) * twice_area[:, :, None]).sum(axis=1)
    return np.asarray(middle[:, 0] + moment / (3.0 * twice_area.sum(axis=1)[:, None]))


def sheet_error_and_told_mm(
    views: Sequence[View], truth: LaserSensor, camera: CameraModel | None
) -> tuple[float, float]:
    """Return the sheet's error over the field and what its covariance expects, RMS.

    Both are NaN where the views do not determine the sensor.
    """
    width, height = truth.camera.width, truth.camera.height
    try:
        sensor = calibrate(views, TARGET, width=width, height=height, camera=camera).sensor
    except CalibError:
        return float("nan"), float("nan")
    field_px = working_field_px(truth)
    covariance = sensor.location_covariance(field_px)
    told = np.sqrt(np.trace(covariance, axis1=1, axis2=2))
    return _rms(sheet_difference_mm(sensor, truth, field_px)), _rms(told)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))
