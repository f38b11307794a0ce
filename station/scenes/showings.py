"""How a rigid target is held before the sensors of a rig, several times."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from calib import BoolArray, FloatArray, RigidTransform, RigSensor
from station.scenes.installation import projector_in_cam_mm
from station.scenes.light import Light
from station.scenes.poses import usable_pose
from station.scenes.rigid_target import MountedBoard, RigidTarget
from station.scenes.target_scene import TargetScene

_TURNS_RAD = (math.radians(15.0), math.radians(35.0))
_SPREAD_MM = 30.0
_OFF_SHEET_MM = 6.0
_DEPTHS_MM = (380.0, 620.0)
_STEEPEST = math.cos(math.radians(52.0))
_TRIES = 4000


@dataclass(frozen=True, slots=True, eq=False)
class Showing:
    """One placing of a rigid target, and what each sensor sees of it.

    Attributes
    ----------
    rig_from_body
        Pose of the target.
    scenes
        By the names of the sensors.
    """

    rig_from_body: RigidTransform
    scenes: Mapping[str, TargetScene]


def rig_showings(
    rng: np.random.Generator,
    sensors: Sequence[RigSensor],
    target: RigidTarget,
    lights: Sequence[Light],
    *,
    all_lit: bool = False,
) -> tuple[Showing, ...]:
    """Draw a showing for each light, turned by 15 to 35 degrees about axes of all directions.

    Parameters
    ----------
    rng
        Draws the poses, and what is left to chance in each picture.
    sensors
        The sensors of a rig, exactly known, each with a board to look at.
    target
        The target.
    lights
        Of each showing, the same for all its pictures.
    all_lit
        Whether the lamps of all boards shine in each picture. A board is lit while its own camera
        exposes: only two boards that cannot be taken for each other may be lit together.

    Returns
    -------
    showings
        In each, all of a sensor's board is in its picture, 380 to 620 mm away and seen at most 52
        degrees aslant; its own stripe crosses it from side to side; no other board stands in the
        way of its camera or its laser.

    Raises
    ------
    ValueError
        If no such pose is found.
    """
    showings = []
    for light in lights:
        rig_from_body = _draw_pose(rng, sensors, target)
        scenes = {
            each.name: _scene(each, target, rig_from_body, light, rng, others_lit=all_lit)
            for each in sensors
        }
        showings.append(Showing(rig_from_body, scenes))
    return tuple(showings)


def _scene(
    each: RigSensor,
    target: RigidTarget,
    rig_from_body: RigidTransform,
    light: Light,
    rng: np.random.Generator,
    *,
    others_lit: bool,
) -> TargetScene:
    own = target.boards[each.name]
    cam_from_body = each.rig_from_camera.inverse() @ rig_from_body
    board = own.placed(cam_from_body, lit=True)
    others = {id(other): other for other in target.boards.values() if other is not own}
    return TargetScene(
        each.sensor,
        board.target,
        board.cam_from_board,
        light,
        seed=int(rng.integers(2**32)),
        dot_shift_mm=board.dot_shift_mm,
        beside=tuple(other.placed(cam_from_body, lit=others_lit) for other in others.values()),
    )


def _draw_pose(
    rng: np.random.Generator, sensors: Sequence[RigSensor], target: RigidTarget
) -> RigidTransform:
    for _ in range(_TRIES):
        rig_from_body = _guess_pose(rng, sensors, target)
        if all(_usable(each, rig_from_body, target) for each in sensors):
            return rig_from_body
    raise ValueError(
        "no pose found in which every sensor sees its board, crossed by its stripe, with nothing "
        "before it; take smaller boards, or boards joined otherwise"
    )


def _guess_pose(
    rng: np.random.Generator, sensors: Sequence[RigSensor], target: RigidTarget
) -> RigidTransform:
    r"""Turn the target as it rests, and move it so that sheets meet boards.

    Notes
    -----
    The shift t from a random one t' minimises
    :math:`\sum_k (n_k t - e_k)^2 / s^2 + |t - t'|^2 / S^2` with e the distance of a random place
    on each board from its sheet: sheets that are nearly parallel cannot all be met exactly.
    """
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(rng.uniform(*_TURNS_RAD) * axis / np.linalg.norm(axis)).as_matrix()
    rest = target.resting
    middle = rest.apply(np.mean([_middle_mm(target.boards[e.name]) for e in sensors], axis=0)[None])
    turned = RigidTransform(turn, middle[0] - turn @ middle[0]) @ rest
    shift = rng.normal(0.0, _SPREAD_MM, 3)
    rows, off_mm = [np.eye(3) / _SPREAD_MM], [shift / _SPREAD_MM]
    for each in sensors:
        board = target.boards[each.name]
        place = turned.apply(_somewhere_mm(rng, board)[None])
        in_cam = each.rig_from_camera.inverse().apply(place)
        normal = each.rig_from_camera.rotation @ each.sensor.plane.normal_in_cam
        rows.append(normal[None] / _OFF_SHEET_MM)
        off_mm.append(-each.sensor.plane.distance_mm(in_cam) / _OFF_SHEET_MM)
    found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(off_mm))[0]
    return RigidTransform(turned.rotation, turned.translation_mm + found)


def _usable(each: RigSensor, rig_from_body: RigidTransform, target: RigidTarget) -> bool:
    board = target.boards[each.name]
    pose = _cam_from_board(each, board, rig_from_body)
    points = pose.apply(board.target.points_mm)
    low, high = points[:, 2].min(), points[:, 2].max()
    if not (_DEPTHS_MM[0] <= low and high <= _DEPTHS_MM[1] and _faces(pose, points)):
        return False
    return usable_pose(pose, each.sensor, board.target) and not any(
        _hidden_by(other.corners_mm, each, board, rig_from_body)
        for other in target.boards.values()
        if other is not board
    )


def _faces(pose: RigidTransform, points: FloatArray) -> bool:
    """Tell whether no point of a board is seen too much aslant."""
    aslant = (points @ pose.rotation[:, 2]) / np.linalg.norm(points, axis=1)
    return bool((aslant >= _STEEPEST).all())


def _hidden_by(
    corners_mm: FloatArray, each: RigSensor, board: MountedBoard, rig_from_body: RigidTransform
) -> bool:
    """Tell whether a rectangle stands before a board's points, from the camera or its laser."""
    body_from_camera = rig_from_body.inverse() @ each.rig_from_camera
    eyes = body_from_camera.apply(np.array([np.zeros(3), projector_in_cam_mm(each.sensor)]))
    points = board.body_from_board.apply(board.target.points_mm)
    return any(bool(crosses_rectangle(corners_mm, eye, points).any()) for eye in eyes)


def crosses_rectangle(
    corners_mm: FloatArray, eye_mm: FloatArray, points_mm: FloatArray
) -> BoolArray:
    """Tell which ways from an eye to points, shape (N, 3), lead through a rectangle."""
    origin, right, down = corners_mm[0], corners_mm[1], corners_mm[3]
    edges = np.column_stack([right - origin, down - origin])
    ways = points_mm - eye_mm
    system = np.concatenate([np.broadcast_to(edges, (len(ways), 3, 2)), -ways[..., None]], axis=2)
    offset = np.broadcast_to(eye_mm - origin, ways.shape)[..., None]
    along_right, along_down, share = np.linalg.solve(system, offset)[..., 0].T
    within = (along_right >= 0.0) & (along_right <= 1.0) & (along_down >= 0.0) & (along_down <= 1.0)
    return np.asarray(within & (share > 0.0) & (share < 1.0))


def _cam_from_board(
    each: RigSensor, board: MountedBoard, rig_from_body: RigidTransform
) -> RigidTransform:
    return each.rig_from_camera.inverse() @ rig_from_body @ board.body_from_board


def _middle_mm(board: MountedBoard) -> FloatArray:
    return np.asarray(board.corners_mm.mean(axis=0))


def _somewhere_mm(rng: np.random.Generator, board: MountedBoard) -> FloatArray:
    """Return a random place of a board that is not near its edge, frame of the body, shape (3,)."""
    origin, right, _, down = board.corners_mm
    across, along = rng.uniform(0.3, 0.7, 2)
    return np.asarray(origin + across * (right - origin) + along * (down - origin))
