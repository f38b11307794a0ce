"""Views of a target and of a stripe across it, made from known truth without a picture.

The geometry is written here a second time, on purpose in another way than in `calib`: the stripe
is traced in space, and a disc's centroid is the mean of many of its points.
"""

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

WIDTH, HEIGHT = 2048, 1088
SIZE = {"width": WIDTH, "height": HEIGHT}
# The paper's simulation.
PAPER_CAMERA = CameraModel.from_parameters(
    np.array([2181.0, 2181.0, 1024.0, 544.0, -0.45, 0.25, 0.0, 0.0, 0.0]), **SIZE
)
PAPER_PLANE = LightPlane.from_coefficients([0.3241, 0.9252, -0.1976, 213.4142])
PAPER_SENSOR = LaserSensor.exact(PAPER_CAMERA, PAPER_PLANE)
PAPER_TARGET = Target.parse("dots:10x10:10")
# The paper's real target and, without its k1 and k2 known in sign, its real camera.
LED_TARGET = Target.parse("dots:7x8:12")
# A noise-free point still needs a sigma.
LEAST_SIGMA_PX = 1e-3


@dataclass(frozen=True)
class Setting:
    """A sensor and the poses of a target before it."""

    sensor: LaserSensor
    target: Target
    poses: tuple[RigidTransform, ...]

    def views(
        self,
        rng: np.random.Generator,
        *,
        dots_px: float,
        stripe_px: float,
        stripe_count: int = 10,
    ) -> list[View]:
        """Draw what is seen with normal noise of these standard deviations."""
        return [
            noisy(self.clean_view(index, stripe_count), rng, dots_px, stripe_px)
            for index in range(len(self.poses))
        ]

    def clean_view(self, index: int, stripe_count: int) -> View:
        pose = self.poses[index]
        return View(
            f"view {index}",
            clean_dots(self.sensor.camera, self.target, pose),
            clean_stripe(self.sensor, self.target, pose, stripe_count),
        )


def setting(
    rng: np.random.Generator,
    count: int,
    *,
    sensor: LaserSensor = PAPER_SENSOR,
    target: Target = PAPER_TARGET,
    tilt_rad: float = 0.5,
) -> Setting:
    """Place a target at random where the sheet crosses its middle and the camera sees it all."""
    poses: list[RigidTransform] = []
    middle = target.points_mm.mean(axis=0)
    while len(poses) < count:
        turn = rng.uniform(-tilt_rad, tilt_rad, 3) * [1.0, 1.0, 0.5]
        ray = sensor.camera.rays(rng.uniform([500.0, 300.0], [1500.0, 800.0])[None])
        point = sensor.plane.intersect(ray)[0]
        if not 350.0 < point[2] < 900.0:
            continue
        rotation = RigidTransform.from_rotation_vector(turn, np.zeros(3)).rotation
        pose = RigidTransform(rotation, point - rotation @ middle)
        seen = sensor.camera.project(pose.apply(target.points_mm))
        if (seen > 10.0).all() and (seen < [WIDTH - 10.0, HEIGHT - 10.0]).all():
            poses.append(pose)
    return Setting(sensor, target, tuple(poses))


def clean_dots(camera: CameraModel, target: Target, pose: RigidTransform) -> TargetPoints:
    row, col = np.divmod(np.arange(target.rows * target.cols), target.cols)
    if target.diameter_mm is None:
        centre = camera.project(pose.apply(target.points_mm))
    else:
        centre = np.array([
            disc_centroid(camera, pose, point, target.diameter_mm) for point in target.points_mm
        ])
    return TargetPoints(
        row=row,
        col=col,
        centre_px=centre,
        sigma_px=np.full(centre.shape, LEAST_SIGMA_PX),
        cause=(Cause.NONE,) * len(row),
    )


def disc_centroid(
    camera: CameraModel, pose: RigidTransform, centre_mm: FloatArray, diameter_mm: float
) -> FloatArray:
    """Average the pictures of a disc's points, each weighted by the picture area it stands for."""
    # Midpoints of rings of equal area; the picture's area by differences of 1e-4 mm.
    rings, spokes = 12, 48
    radius = diameter_mm / 2.0 * np.sqrt((np.arange(rings) + 0.5) / rings)
    angle = 2.0 * np.pi * np.arange(spokes) / spokes
    offsets = np.stack(
        [
            np.outer(radius, np.cos(angle)).ravel(),
            np.outer(radius, np.sin(angle)).ravel(),
            np.zeros(rings * spokes),
        ],
        axis=1,
    )

    def seen(shift: list[float]) -> FloatArray:
        return camera.project(pose.apply(centre_mm + offsets + np.array(shift)))

    along = seen([1e-4, 0.0, 0.0]) - seen([-1e-4, 0.0, 0.0])
    across = seen([0.0, 1e-4, 0.0]) - seen([0.0, -1e-4, 0.0])
    area = np.abs(along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0])
    return np.average(seen([0.0, 0.0, 0.0]), axis=0, weights=area)


def clean_stripe(
    sensor: LaserSensor, target: Target, pose: RigidTransform, count: int
) -> StripePoints:
    """Trace the line where sheet and board meet, as far as it lies on the board."""
    plane_on_board = pose.rotation.T @ sensor.plane.normal_in_cam
    offset = sensor.plane.distance_mm(pose.translation_mm[None])[0]
    along = np.array([-plane_on_board[1], plane_on_board[0]])
    along /= np.linalg.norm(along)
    foot = -offset * plane_on_board[:2] / (plane_on_board[:2] @ plane_on_board[:2])
    reach = np.linspace(-1e3, 1e3, 200_001)
    on_line = foot + reach[:, None] * along
    edge = target.pitch_mm / 2.0
    far = target.points_mm[:, :2].max(axis=0) + edge
    inside = reach[((on_line > -edge) & (on_line < far)).all(axis=1)]
    place = np.linspace(inside[0], inside[-1], count)

    def seen(shift: float) -> FloatArray:
        points = foot + (place + shift)[:, None] * along
        return sensor.camera.project(pose.apply(np.column_stack([points, np.zeros(count)])))

    tangent = seen(1e-3) - seen(-1e-3)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return StripePoints(
        centre_px=seen(0.0),
        normal=normal,
        sigma_px=np.full(count, LEAST_SIGMA_PX),
        width_px=np.full(count, 2.0),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def noisy(view: View, rng: np.random.Generator, dots_px: float, stripe_px: float) -> View:
    """Add normal noise, and say so in the sigmas."""
    dots, stripe = view.points, view.stripe
    assert stripe is not None
    shift = rng.normal(0.0, 1.0, len(stripe)) * stripe_px
    return View(
        view.name,
        replace(
            dots,
            centre_px=dots.centre_px + rng.normal(0.0, 1.0, dots.centre_px.shape) * dots_px,
            sigma_px=np.full(dots.centre_px.shape, max(dots_px, LEAST_SIGMA_PX)),
        ),
        replace(
            stripe,
            centre_px=stripe.centre_px + shift[:, None] * stripe.normal,
            sigma_px=np.full(len(stripe), max(stripe_px, LEAST_SIGMA_PX)),
        ),
    )
