"""Showings of a rigid target to a rig, as points without a picture: their noise is known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    RIG_PARAMETERS,
    CameraModel,
    Cause,
    FloatArray,
    LaserSensor,
    LightPlane,
    Rig,
    RigidTransform,
    RigSensor,
    RigShowing,
    StripePoints,
    Target,
    TargetPoints,
    View,
    cramer_rao_bound,
)
from station.bench.simulation import Noise
from station.scenes import Light, RigidTarget, WheelRig, rig_showings, target_poses

_FREE_CAMERA = range(6)
"""fx, fy, cx, cy, k1, k2."""


@dataclass(frozen=True, slots=True, eq=False)
class PointRig:
    """The rig of a wheel as designed, and how well calibrations of its sensors know them.

    Attributes
    ----------
    designed
        The sensors and where they stand.
    known
        The sensors, each with the covariance of a calibration.
    target
        Of all boards.
    stripe_points
        Of each picture.
    noise
        Of all points.
    """

    designed: WheelRig
    known: Mapping[str, LaserSensor]
    target: Target
    stripe_points: int
    noise: Noise

    @classmethod
    def trackside(
        cls,
        rng: np.random.Generator,
        target: Target,
        noise: Noise,
        *,
        poses: int,
        stripe_points: int,
    ) -> "PointRig":
        """Make the rig of a left wheel, its sensors calibrated from so many poses."""
        designed = WheelRig.trackside("left")
        known = {}
        for each in designed.sensors:
            held = target_poses(rng, poses, each.sensor, target)
            places = target.points_mm
            views = [
                _view(each.sensor, target, pose, places, stripe_points, noise, rng) for pose in held
            ]
            covariance = cramer_rao_bound(
                views, target, each.sensor, held, free_camera=_FREE_CAMERA
            )
            known[each.name] = LaserSensor(each.sensor.camera, each.sensor.plane, covariance)
        return cls(designed, known, target, stripe_points, noise)

    def held(
        self, rng: np.random.Generator, count: int
    ) -> tuple[RigidTarget, list[RigidTransform]]:
        """Return a target for the rig, and so many places to hold it in."""
        body = RigidTarget.board_each(rng, self.designed.sensors, self.target)
        lights = [Light.GOOD] * count
        shown = rig_showings(rng, self.designed.sensors, body, lights)
        return body, [each.rig_from_body for each in shown]

    def drawn_truth(self, rng: np.random.Generator) -> dict[str, LaserSensor]:
        """Return the sensors as they may truly be, by what is known of them."""
        return {name: _drawn(sensor, rng) for name, sensor in self.known.items()}

    def exact(self, truth: Mapping[str, LaserSensor]) -> Rig:
        """Return the rig as it truly stands, with these sensors."""
        size = len(truth) * len(RIG_PARAMETERS)
        sensors = tuple(
            RigSensor(each.name, truth[each.name], each.rig_from_camera)
            for each in self.designed.sensors
        )
        return Rig(sensors, np.zeros((size, size)))

    def showings(
        self,
        rng: np.random.Generator,
        truth: Mapping[str, LaserSensor],
        body: RigidTarget,
        held: Sequence[RigidTransform],
        sigma_board_mm: float,
    ) -> list[RigShowing]:
        """Draw the boards' errors, the same in all showings, and what the true sensors see."""
        size = (len(self.target.points_mm), 3)
        places = {
            name: self.target.points_mm + rng.normal(0.0, sigma_board_mm, size) for name in truth
        }
        found = []
        for number, rig_from_body in enumerate(held):
            views = {}
            for each in self.designed.sensors:
                cam_from_body = each.rig_from_camera.inverse() @ rig_from_body
                pose = cam_from_body @ body.boards[each.name].body_from_board
                view = _view(
                    truth[each.name],
                    self.target,
                    pose,
                    places[each.name],
                    self.stripe_points,
                    self.noise,
                    rng,
                )
                views[each.name] = (each.name, view)
            found.append(RigShowing(f"showing {number}", views))
        return found


def _drawn(sensor: LaserSensor, rng: np.random.Generator) -> LaserSensor:
    scale = np.sqrt(np.diag(sensor.covariance))
    safe = np.where(scale > 0.0, scale, 1.0)
    values, axes = np.linalg.eigh(sensor.covariance / np.outer(safe, safe))
    root = scale[:, None] * axes * np.sqrt(np.maximum(values, 0.0))
    step = root @ rng.normal(size=len(scale))
    camera = sensor.camera
    return LaserSensor.exact(
        CameraModel.from_parameters(
            camera.parameters + step[:9], width=camera.width, height=camera.height
        ),
        LightPlane.from_coefficients(sensor.plane.coefficients + step[9:]),
    )


def _view(
    sensor: LaserSensor,
    target: Target,
    pose: RigidTransform,
    places_mm: FloatArray,
    stripe_points: int,
    noise: Noise,
    rng: np.random.Generator,
) -> View:
    centre = sensor.camera.project(pose.apply(places_mm))
    row, col = np.divmod(np.arange(len(places_mm)), target.cols)
    dots = TargetPoints(
        row=row,
        col=col,
        centre_px=centre + rng.normal(0.0, noise.dots_px, centre.shape),
        sigma_px=np.full(centre.shape, noise.dots_px),
        cause=(Cause.NONE,) * len(row),
    )
    return View("points", dots, _stripe(sensor, target, pose, stripe_points, noise, rng))


def _stripe(
    sensor: LaserSensor,
    target: Target,
    pose: RigidTransform,
    count: int,
    noise: Noise,
    rng: np.random.Generator,
) -> StripePoints:
    """Return points of the line where the sheet meets the board, from one side of it to the other.

    In the board's frame the sheet is ``slope @ (x, y) + offset = 0``.
    """
    slope = (pose.rotation.T @ sensor.plane.normal_in_cam)[:2]
    offset_mm = float(sensor.plane.distance_mm(pose.translation_mm[None])[0])
    x = np.linspace(0.0, (target.cols - 1) * target.pitch_mm, count)

    def seen(shift_mm: float) -> FloatArray:
        y = -(offset_mm + slope[0] * (x + shift_mm)) / slope[1]
        on_board = np.column_stack([x + shift_mm, y, np.zeros(count)])
        return sensor.camera.project(pose.apply(on_board))

    along = seen(1e-3) - seen(-1e-3)
    length = np.linalg.norm(along, axis=1)
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
    off_px = rng.normal(0.0, noise.stripe_px, count)
    return StripePoints(
        centre_px=seen(0.0) + off_px[:, None] * normal,
        normal=normal,
        sigma_px=np.full(count, noise.stripe_px),
        width_px=np.full(count, 2.0),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
