"""The paper's simulation: points of a target and of the stripe across it, without a picture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import (
    CameraModel,
    Cause,
    FloatArray,
    LaserSensor,
    LightPlane,
    RigidTransform,
    StripePoints,
    Target,
    TargetPoints,
    View,
)

WIDTH_PX, HEIGHT_PX = 2048, 1088
TARGET = Target.parse("dots:10x10:10")
SENSOR = LaserSensor.exact(
    CameraModel.from_parameters(
        np.array([2181.0, 2181.0, 1024.0, 544.0, -0.45, 0.25, 0.0, 0.0, 0.0]),
        width=WIDTH_PX,
        height=HEIGHT_PX,
    ),
    LightPlane.from_coefficients([0.3241, 0.9252, -0.1976, 213.4142]),
)

_LEAST_SIGMA_PX = 1e-3
"""A point free of noise still needs a sigma."""
_TILT_RAD = 0.5
_DEPTHS_MM = (350.0, 900.0)
_MIDDLE_PX = ([500.0, 300.0], [1500.0, 800.0])
_MARGIN_PX = 10.0


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of the noise, px: of a dot along u and v, of a stripe point across."""

    dots_px: float
    stripe_px: float


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """One draw of the noise: what is seen, and what moved each point.

    Attributes
    ----------
    views
        M views.
    dots_px
        Shape (M, N, 2), observed less true.
    stripe_px
        Shape (M, L), the same across the stripe.
    """

    views: Sequence[View]
    dots_px: FloatArray
    stripe_px: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """The target in some poses, seen without noise; its noise is drawn from here."""

    poses: tuple[RigidTransform, ...]
    clean: tuple[View, ...]

    @classmethod
    def drawn(cls, count: int, seed: int | Sequence[int]) -> "Simulation":
        """Hold the target at random where the sheet crosses its middle and all of it is seen."""
        rng = np.random.default_rng(seed)
        poses: list[RigidTransform] = []
        while len(poses) < count:
            pose = _guess_pose(rng)
            if pose is not None:
                poses.append(pose)
        views = tuple(_clean_view(f"pose {index}", pose) for index, pose in enumerate(poses))
        return cls(tuple(poses), views)

    def noisy(self, rng: np.random.Generator, noise: Noise) -> Drawn:
        """Draw normal noise and return what is seen; the sigmas of the views are true."""
        dots = rng.normal(size=(len(self.clean), len(TARGET.points_mm), 2)) * noise.dots_px
        stripe = rng.normal(size=(len(self.clean), TARGET.cols)) * noise.stripe_px
        views = [
            _moved(view, by_dot, by_stripe, noise)
            for view, by_dot, by_stripe in zip(self.clean, dots, stripe, strict=True)
        ]
        return Drawn(views, dots, stripe)

    def off_sheet_mm(
        self, index: int, pose: RigidTransform, plane: LightPlane, moved_px: float = 0.0
    ) -> FloatArray:
        """Return how far off a plane the board lies under the stripe's true pixels, shape (L,).

        Parameters
        ----------
        index
            Of the view whose stripe it is.
        pose, plane
            Of the board and of the light, as they may be.
        moved_px
            Moves the pixels across the stripe first.
        """
        stripe = _stripe_of(self.clean[index])
        rays = SENSOR.camera.rays(stripe.centre_px + moved_px * stripe.normal)
        normal = pose.rotation[:, 2]
        depth = normal @ pose.translation_mm / (rays @ normal)
        return plane.distance_mm(rays * depth[:, None])


def told(sigma_px: float) -> float:
    """Return the sigma that a view tells of noise of this size."""
    return max(sigma_px, _LEAST_SIGMA_PX)


def _guess_pose(rng: np.random.Generator) -> RigidTransform | None:
    turn = rng.uniform(-_TILT_RAD, _TILT_RAD, 3) * [1.0, 1.0, 0.5]
    on_sheet = SENSOR.locate(rng.uniform(*_MIDDLE_PX)[None])[0]
    if not _DEPTHS_MM[0] < on_sheet[2] < _DEPTHS_MM[1]:
        return None
    rotation = RigidTransform.from_rotation_vector(turn, np.zeros(3)).rotation
    pose = RigidTransform(rotation, on_sheet - rotation @ TARGET.points_mm.mean(axis=0))
    seen = SENSOR.camera.project(pose.apply(TARGET.points_mm))
    size = np.array([WIDTH_PX, HEIGHT_PX])
    inside = (seen > _MARGIN_PX).all() and (seen < size - _MARGIN_PX).all()
    return pose if inside else None


def _clean_view(name: str, pose: RigidTransform) -> View:
    row, col = np.divmod(np.arange(len(TARGET.points_mm)), TARGET.cols)
    centre = SENSOR.camera.project(pose.apply(TARGET.points_mm))
    dots = TargetPoints(
        row, col, centre, np.full(centre.shape, told(0.0)), (Cause.NONE,) * len(row)
    )
    return View(name, dots, _clean_stripe(pose))


def _clean_stripe(pose: RigidTransform) -> StripePoints:
    """Return the stripe where it meets the columns of dots: one point a column, as in the paper."""
    count = TARGET.cols
    on_board = pose.rotation.T @ SENSOR.plane.normal_in_cam
    offset = float(SENSOR.plane.distance_mm(pose.translation_mm[None])[0])

    def seen(shift_mm: float) -> FloatArray:
        x = np.arange(count) * TARGET.pitch_mm + shift_mm
        y = -(offset + on_board[0] * x) / on_board[1]
        return SENSOR.camera.project(pose.apply(np.column_stack([x, y, np.zeros(count)])))

    along = seen(1e-3) - seen(-1e-3)
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    return StripePoints(
        centre_px=seen(0.0),
        normal=normal / np.linalg.norm(normal, axis=1)[:, None],
        sigma_px=np.full(count, told(0.0)),
        width_px=np.full(count, 2.0),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def _stripe_of(view: View) -> StripePoints:
    if view.stripe is None:
        raise ValueError(f"{view.name} was simulated with a stripe")
    return view.stripe


def _moved(view: View, dots_px: FloatArray, stripe_px: FloatArray, noise: Noise) -> View:
    dots, stripe = view.points, _stripe_of(view)
    return replace(
        view,
        points=replace(
            dots,
            centre_px=dots.centre_px + dots_px,
            sigma_px=np.full(dots.centre_px.shape, told(noise.dots_px)),
        ),
        stripe=replace(
            stripe,
            centre_px=stripe.centre_px + stripe_px[:, None] * stripe.normal,
            sigma_px=np.full(len(stripe), told(noise.stripe_px)),
        ),
    )
