"""Where a target is held before the sensor, as somebody who calibrates would hold it."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from calib import CameraModel, FloatArray, LaserSensor, LightPlane, RigidTransform, Target
from station.scenes.board import dot_radius_mm, outline_mm
from station.scenes.crossing import crossing_on_board
from station.scenes.light import Light
from station.scenes.target_scene import TargetScene

_TILTS_RAD = (math.radians(10.0), math.radians(35.0))
_TURN_RAD = math.radians(10.0)
_DEPTHS_MM = (400.0, 600.0)
_MARGIN_PX = 12.0
_TRIES = 2000


def target_poses(
    rng: np.random.Generator, count: int, sensor: LaserSensor, target: Target
) -> tuple[RigidTransform, ...]:
    """Draw poses of a target: all of it in view, crossed by the sheet, tilted 10 to 35 degrees.

    Parameters
    ----------
    rng
        Draws them.
    count
        How many.
    sensor
        The camera and the sheet.
    target
        The target.

    Returns
    -------
    poses
        `count` maps cam_from_board. The stripe crosses every column between the first and
        the last row; depths lie between 400 and 600 mm.

    Raises
    ------
    ValueError
        If the target is too large for the field, or the sheet passes beside the field.
    """
    return tuple(_draw_pose(rng, sensor, target) for _ in range(count))


def pose_through_dots(
    sensor: LaserSensor, target: Target, cam_from_board: RigidTransform
) -> RigidTransform:
    """Move a target within its own plane until the stripe runs along its middle row.

    Parameters
    ----------
    sensor
        The camera and the sheet.
    target
        The target.
    cam_from_board
        A pose; its plane, and so the line the sheet draws in it, stays as it is.

    Returns
    -------
    cam_from_board
        The stripe passes the middle of the row and leaves it by 2 degrees, so that it crosses
        some dots through their middle and touches others at their edge.

    Raises
    ------
    ValueError
        If the sheet is parallel to the target.
    """
    middle = np.array([(target.cols - 1) / 2.0, target.rows // 2]) * target.pitch_mm
    crossing = crossing_on_board(sensor.plane, cam_from_board, middle)
    if crossing is None:
        raise ValueError("the sheet is parallel to the target; tilt the target")
    turn = math.atan2(crossing.direction[1], crossing.direction[0]) - math.radians(2.0)
    rotation = Rotation.from_euler("z", turn).as_matrix()
    origin = np.append(crossing.nearest_mm, 0.0) - rotation @ np.append(middle, 0.0)
    return cam_from_board @ RigidTransform(rotation, origin)


def target_scenes(
    rng: np.random.Generator, sensor: LaserSensor, target: Target, lights: Sequence[Light]
) -> tuple[TargetScene, ...]:
    """Draw a scene for each light, each in a pose of its own.

    Under ``Light.CROSSING`` the target is held so that the stripe runs through dots.

    Raises
    ------
    ValueError
        As `target_poses`.
    """
    scenes = []
    for light in lights:
        pose = _draw_pose(rng, sensor, target, through_dots=light is Light.CROSSING)
        seed = int(rng.integers(2**32))
        scenes.append(TargetScene(sensor, target, pose, light, seed=seed))
    return tuple(scenes)


def _draw_pose(
    rng: np.random.Generator, sensor: LaserSensor, target: Target, *, through_dots: bool = False
) -> RigidTransform:
    for _ in range(_TRIES):
        pose = _guess_pose(rng, sensor, target)
        if pose is not None and through_dots:
            pose = pose_through_dots(sensor, target, pose)
        if pose is not None and usable_pose(pose, sensor, target):
            return pose
    low, high = outline_mm(target)
    width, height = high - low
    raise ValueError(
        f"no pose found in which a target of {width:.0f} x {height:.0f} mm is in view and crossed "
        "by the sheet; take a smaller target or another sensor"
    )


def _guess_pose(
    rng: np.random.Generator, sensor: LaserSensor, target: Target
) -> RigidTransform | None:
    """Put a random place of the target on a random place of the sheet, or None behind it."""
    camera = sensor.camera
    pixel = rng.uniform([0.0, 0.0], [camera.width, camera.height])
    on_sheet = sensor.locate(pixel[None])[0]
    if not _DEPTHS_MM[0] <= on_sheet[2] <= _DEPTHS_MM[1]:
        return None
    last = np.array([target.cols - 1, target.rows - 1]) * target.pitch_mm
    on_board = np.append(last * rng.uniform(0.2, 0.8, 2), 0.0)
    towards = rng.uniform(0.0, 2.0 * math.pi)
    tilt = rng.uniform(*_TILTS_RAD) * np.array([math.cos(towards), math.sin(towards), 0.0])
    turn = Rotation.from_euler("z", rng.uniform(-_TURN_RAD, _TURN_RAD))
    rotation = (Rotation.from_rotvec(tilt) * turn).as_matrix()
    return RigidTransform(rotation, on_sheet - rotation @ on_board)


def usable_pose(pose: RigidTransform, sensor: LaserSensor, target: Target) -> bool:
    """Tell whether all points are in view, and the stripe crosses them from side to side."""
    return _in_view(pose, sensor.camera, target) and _crossed(pose, sensor.plane, target)


def _in_view(pose: RigidTransform, camera: CameraModel, target: Target) -> bool:
    points = pose.apply(target.points_mm)
    if not points[:, 2].min() > 0.0:
        return False
    # A dot's picture reaches this far around its centre.
    reach_px = camera.fx * dot_radius_mm(target) / points[:, 2].min() + _MARGIN_PX
    pixels = camera.project(points)
    size = np.array([camera.width, camera.height]) - 1.0
    return bool((pixels >= reach_px).all() and (pixels <= size - reach_px).all())


def _crossed(pose: RigidTransform, plane: LightPlane, target: Target) -> bool:
    """Tell whether the stripe meets the first and last column between the first and last row."""
    last: FloatArray = np.array([target.cols - 1, target.rows - 1]) * target.pitch_mm
    crossing = crossing_on_board(plane, pose, last / 2.0)
    if crossing is None or not abs(crossing.direction[0]) > 0.5:
        return False
    slope = crossing.direction[1] / crossing.direction[0]
    ends = crossing.nearest_mm[1] + slope * (np.array([0.0, last[0]]) - crossing.nearest_mm[0])
    return bool((ends >= 0.0).all() and (ends <= last[1]).all())
