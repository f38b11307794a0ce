"""A rigid calibration target of one board or more, as a workshop makes it: never quite exactly."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform, RigSensor, Target, moved_by
from station.scenes.board import checked_shifts, outline_mm
from station.scenes.placed_board import PlacedBoard, corners_mm

_APART_MM = 40.0
_JOINT_TURN_RAD, _JOINT_SHIFT_MM = 0.03, 3.0


@dataclass(frozen=True, slots=True, eq=False)
class MountedBoard:
    """One board of a rigid target.

    Attributes
    ----------
    target
        Its points as they should be.
    body_from_board
        Where it is mounted.
    dot_shift_mm
        Shape (rows * cols, 2): how far each dot is printed from its place, in all pictures.

    Raises
    ------
    ValueError
        As `PlacedBoard`.
    """

    target: Target
    body_from_board: RigidTransform
    dot_shift_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "dot_shift_mm", checked_shifts(self.target, self.dot_shift_mm))

    @property
    def corners_mm(self) -> FloatArray:
        """Corners of the board in the frame of the body, in order round it, shape (4, 3)."""
        return self.body_from_board.apply(corners_mm(self.target))

    def placed(self, cam_from_body: RigidTransform, *, lit: bool) -> PlacedBoard:
        """Return the board in the frame of a camera, its lamps on or off."""
        pose = cam_from_body @ self.body_from_board
        return PlacedBoard(self.target, pose, self.dot_shift_mm, lit)


@dataclass(frozen=True, slots=True, eq=False)
class RigidTarget:
    """Boards joined for good; the frame of the body is that of the first board.

    Attributes
    ----------
    boards
        The board each sensor looks at, by the sensor's name. Several may look at the same one.
    resting
        The rig_from_body in which it is held to begin with: boards face their cameras, on their
        sheets.

    Raises
    ------
    ValueError
        If there is no board.
    """

    boards: Mapping[str, MountedBoard]
    resting: RigidTransform

    def __post_init__(self) -> None:
        if not self.boards:
            raise ValueError("a rigid target needs a board at least, got none")
        object.__setattr__(self, "boards", MappingProxyType(dict(self.boards)))

    @classmethod
    def board_each(
        cls,
        rng: np.random.Generator,
        sensors: Sequence[RigSensor],
        targets: Target | Sequence[Target],
        *,
        printing_sigma_mm: float = 0.0,
    ) -> "RigidTarget":
        """Make a target with a board for each sensor: a roof whose sides face their cameras.

        Parameters
        ----------
        rng
            Draws how the boards are joined, some degrees and millimetres from what was wanted,
            and the errors of the printing.
        sensors
            What it is made for.
        targets
            The board of each sensor, or the same for all.
        printing_sigma_mm
            Standard deviation of the place of a dot, along rows and along columns.
        """
        of_each = [targets] * len(sensors) if isinstance(targets, Target) else targets
        poses = _board_poses(sensors, of_each)
        first = poses[0]
        boards: dict[str, MountedBoard] = {}
        for each, target, rig_from_board in zip(sensors, of_each, poses, strict=True):
            joint = RigidTransform.identity()
            if boards:
                turn = rng.normal(0.0, _JOINT_TURN_RAD, 3)
                shift = rng.normal(0.0, _JOINT_SHIFT_MM, 3)
                wanted = first.inverse() @ rig_from_board
                joint = moved_by(wanted, np.concatenate([turn, shift]))
            shifts = _printing_errors(rng, target, printing_sigma_mm)
            boards[each.name] = MountedBoard(target, joint, shifts)
        return cls(boards, first)

    @classmethod
    def shared_board(
        cls,
        rng: np.random.Generator,
        sensors: Sequence[RigSensor],
        target: Target,
        *,
        printing_sigma_mm: float = 0.0,
    ) -> "RigidTarget":
        """Make a single board that all sensors look at; parameters as `board_each`."""
        shifts = _printing_errors(rng, target, printing_sigma_mm)
        board = MountedBoard(target, RigidTransform.identity(), shifts)
        return cls({each.name: board for each in sensors}, _between_cameras(sensors, target))


def _board_poses(
    sensors: Sequence[RigSensor], targets: Sequence[Target]
) -> tuple[RigidTransform, ...]:
    """Return rig_from_board of a board for each sensor, square to its camera and on its sheet.

    Boards are 40 mm off the middle of the field, each to its own camera's side along the axle, so
    that none stands before another.
    """
    middle_mm = np.mean([each.rig_from_camera.translation_mm for each in sensors], axis=0)
    poses = []
    for each, target in zip(sensors, targets, strict=True):
        side = np.sign(each.rig_from_camera.translation_mm[1] - middle_mm[1])
        place = _axis_on_sheet_mm(each) + np.array([0.0, side * _APART_MM, 0.0])
        poses.append(each.rig_from_camera @ _square_to_camera(each, place, target))
    return tuple(poses)


def _axis_on_sheet_mm(each: RigSensor) -> FloatArray:
    """Return where the axis of a camera meets the sheet, in the rig frame, shape (3,)."""
    on_axis = each.sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]]))
    return np.asarray(each.rig_from_camera.apply(on_axis)[0])


def _square_to_camera(each: RigSensor, place_mm: FloatArray, target: Target) -> RigidTransform:
    """Return cam_from_board with the board's middle on the sheet, seen where a place is."""
    sensor: LaserSensor = each.sensor
    in_cam = each.rig_from_camera.inverse().apply(place_mm[None])
    on_sheet = sensor.locate(sensor.camera.project(in_cam))[0]
    return RigidTransform(np.eye(3), on_sheet - np.append(outline_mm(target).mean(axis=0), 0.0))


def _between_cameras(sensors: Sequence[RigSensor], target: Target) -> RigidTransform:
    """Return rig_from_board of a board in the middle of the fields that faces all cameras."""
    middle_mm = np.mean([_axis_on_sheet_mm(each) for each in sensors], axis=0)
    ways = [middle_mm - each.rig_from_camera.translation_mm for each in sensors]
    away = np.sum([way / np.linalg.norm(way) for way in ways], axis=0)
    away /= np.linalg.norm(away)
    along = np.sum([each.rig_from_camera.rotation[:, 0] for each in sensors], axis=0)
    along -= (along @ away) * away
    along /= np.linalg.norm(along)
    rotation = np.column_stack([along, np.cross(away, along), away])
    on_board = np.append(outline_mm(target).mean(axis=0), 0.0)
    return RigidTransform(rotation, middle_mm - rotation @ on_board)


def _printing_errors(rng: np.random.Generator, target: Target, sigma_mm: float) -> FloatArray:
    return rng.normal(0.0, sigma_mm, (target.rows * target.cols, 2))
