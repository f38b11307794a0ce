"""Two cameras, one wheel place between them, and a rigid target of two boards shown to both."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from synthetic_views import SIZE, clean_dots, noisy, setting

from calib import (
    CameraModel,
    Cause,
    FloatArray,
    LaserSensor,
    LightPlane,
    RigidTransform,
    RigShowing,
    StripePoints,
    Target,
    View,
    cramer_rao_bound,
)

CAMERA = CameraModel.from_parameters(
    np.array([2181.0, 2181.0, 1024.0, 544.0, -0.09, 0.12, 0.0, 0.0, 0.0]), **SIZE
)
# 35 degrees off the camera's axis, which it meets at 486 mm.
SHEET = LightPlane.from_coefficients([0.05, 0.818, -0.573, 0.573 * 486.0])
BOARD = Target.parse("dots:7x8:12")
FREE = (0, 1, 2, 3, 4, 5)
DOTS_PX, STRIPE_PX = 0.05, 0.1


def calibrated(rng: np.random.Generator) -> LaserSensor:
    """Return a sensor as a calibration with 20 views of dots of 0.05 px knows it."""
    exact = LaserSensor.exact(CAMERA, SHEET)
    single = setting(rng, 20, sensor=exact, target=BOARD)
    views = single.views(rng, dots_px=DOTS_PX, stripe_px=STRIPE_PX, stripe_count=200)
    covariance = cramer_rao_bound(views, BOARD, exact, single.poses, free_camera=FREE)
    return LaserSensor(CAMERA, SHEET, covariance)


def drawn(sensor: LaserSensor, rng: np.random.Generator) -> LaserSensor:
    """Return a sensor as it may truly be, where `sensor` is what is known of it."""
    scale = np.sqrt(np.diag(sensor.covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    values, axes = np.linalg.eigh(sensor.covariance / np.outer(safe, safe))
    root = scale[:, None] * axes * np.sqrt(np.maximum(values, 0.0))
    step = root @ rng.normal(size=13)
    camera = CameraModel.from_parameters(sensor.camera.parameters + step[:9], **SIZE)
    plane = LightPlane.from_coefficients(sensor.plane.coefficients + step[9:])
    return LaserSensor.exact(camera, plane)


def about(axis: Sequence[float], degrees: float) -> FloatArray:
    turn = np.radians(degrees) * np.array(axis) / np.linalg.norm(axis)
    return RigidTransform.from_rotation_vector(turn, np.zeros(3)).rotation


@dataclass(frozen=True)
class RigScene:
    """True sensors, where they stand, and the target of boards that they look at.

    `rig_from_camera` by sensor; `target_from_board` by board; `looks_at` the board of each sensor.
    """

    sensors: Mapping[str, LaserSensor]
    rig_from_camera: Mapping[str, RigidTransform]
    boards: Mapping[str, Target]
    target_from_board: Mapping[str, RigidTransform]
    looks_at: Mapping[str, str]

    def cam_from_board(self, name: str, rig_from_target: RigidTransform) -> RigidTransform:
        camera = self.rig_from_camera[name].inverse()
        return camera @ rig_from_target @ self.target_from_board[self.looks_at[name]]

    def showing(
        self,
        name: str,
        rig_from_target: RigidTransform,
        rng: np.random.Generator,
        shifts: Mapping[str, FloatArray],
        *,
        sensors: Sequence[str] | None = None,
        stripe_count: int = 200,
        noise: tuple[float, float] = (DOTS_PX, STRIPE_PX),
    ) -> RigShowing:
        """Draw what the sensors see of boards whose dots are shifted, mm, shapes (N, 3)."""
        views = {}
        for sensor in sensors or self.sensors:
            board = self.looks_at[sensor]
            pose = self.cam_from_board(sensor, rig_from_target)
            clean = view_of(
                self.sensors[sensor], self.boards[board], pose, shifts[board], stripe_count
            )
            views[sensor] = (board, noisy(clean, rng, *noise))
        return RigShowing(name, views)


def view_of(
    sensor: LaserSensor,
    target: Target,
    pose: RigidTransform,
    shift_mm: FloatArray,
    stripe_count: int,
) -> View:
    dots = clean_dots(sensor.camera, target, pose)
    centre = sensor.camera.project(pose.apply(target.points_mm + shift_mm))
    return View(
        "view",
        replace(dots, centre_px=centre),
        stripe_on(sensor, target, pose, stripe_count),
    )


def stripe_on(
    sensor: LaserSensor, target: Target, pose: RigidTransform, count: int
) -> StripePoints:
    """Trace the line where sheet and board meet, as far as it lies on the board."""
    across = pose.rotation.T @ sensor.plane.normal_in_cam
    offset = sensor.plane.distance_mm(pose.translation_mm[None])[0]
    along = np.array([-across[1], across[0]]) / np.hypot(*across[:2])
    foot = -offset * across[:2] / (across[:2] @ across[:2])
    edge = target.pitch_mm / 2.0
    ends = np.array([[-edge], [edge]]) + [[0.0], [1.0]] * target.points_mm[:, :2].max(axis=0)
    with np.errstate(divide="ignore"):
        reach = np.sort((ends - foot) / along, axis=0)
    place = np.linspace(reach[0].max() + 1e-6, reach[1].min() - 1e-6, count)

    def seen(shift: float) -> FloatArray:
        points = foot + (place + shift)[:, None] * along
        return sensor.camera.project(pose.apply(np.column_stack([points, np.zeros(count)])))

    tangent = seen(1e-3) - seen(-1e-3)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    return StripePoints(
        centre_px=seen(0.0),
        normal=normal / np.linalg.norm(normal, axis=1)[:, None],
        sigma_px=np.full(count, STRIPE_PX),
        width_px=np.full(count, 2.0),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def two_boards(sensors: Mapping[str, LaserSensor], *, between_deg: float = 80.0) -> RigScene:
    """Stand two sensors about one place, their cameras' axes so far apart; the first is the rig.

    The section plane is that of the first sheet; its middle is in front of both cameras.
    """
    first, second = sensors
    middle = np.array([0.0, 0.0, 486.0])
    turn = about([1.0, 0.0, 0.0], between_deg) @ about([0.0, 0.0, 1.0], 5.0)
    rig_from_second = RigidTransform(turn, middle - turn @ middle)
    board = BOARD.points_mm.mean(axis=0)
    facing = RigidTransform(np.eye(3), -board)
    other = RigidTransform(turn, np.array([3.0, 8.0, 4.0]) - turn @ board)
    return RigScene(
        sensors=sensors,
        rig_from_camera={first: RigidTransform.identity(), second: rig_from_second},
        boards={"one": BOARD, "other": BOARD},
        target_from_board={"one": facing, "other": other},
        looks_at={first: "one", second: "other"},
    )


def placings(
    rng: np.random.Generator, scene: RigScene, count: int, *, tilt_deg: float = 20.0
) -> list[RigidTransform]:
    """Place the target where both cameras see their boards whole and the sheets cross them."""
    found: list[RigidTransform] = []
    while len(found) < count:
        turn = np.radians(rng.uniform(-tilt_deg, tilt_deg, 3))
        place = np.array([0.0, 0.0, 486.0]) + rng.uniform(-25.0, 25.0, 3)
        pose = RigidTransform.from_rotation_vector(turn, place)
        if all(_seen_whole(scene, name, pose) for name in scene.sensors):
            found.append(pose)
    return found


def _seen_whole(scene: RigScene, name: str, rig_from_target: RigidTransform) -> bool:
    sensor, target = scene.sensors[name], scene.boards[scene.looks_at[name]]
    pose = scene.cam_from_board(name, rig_from_target)
    points = pose.apply(target.points_mm)
    seen = sensor.camera.project(points)
    facing = pose.rotation[2, 2] > 0.5
    inside = (seen > 10.0).all() and (seen < [SIZE["width"] - 10.0, SIZE["height"] - 10.0]).all()
    distance = sensor.plane.distance_mm(points)
    return bool(facing and inside and distance.min() < -15.0 and distance.max() > 15.0)


def board_errors(
    rng: np.random.Generator, scene: RigScene, sigma_mm: float
) -> dict[str, FloatArray]:
    return {
        name: rng.normal(size=(len(target.points_mm), 3)) * sigma_mm
        for name, target in scene.boards.items()
    }
