"""The paper's Tables 1 and 2: how far dots and stripe are seen off, before and after correction."""

from collections.abc import Sequence

import numpy as np

from calib import (
    CalibError,
    Calibration,
    FloatArray,
    LaserSensor,
    Method,
    SolvedPoints,
    StripePoints,
    calibrate,
)
from station.bench.paper_pictures import TARGET, SeenTarget, see_targets
from station.progress import Progress
from station.scenes import Light, TargetScene, paper_sensor
from station.tables import Table, Value

_RINGS, _SPOKES = 6, 24
_STEP_PX = 0.5


def bench_deviations(progress: Progress, *, poses: int = 20, seed: int = 1) -> Table:
    """Compare observed and corrected points of every light with where they truly are.

    Parameters
    ----------
    progress
        Told where the bench is.
    poses
        Pictures a light; one calibration is made of them.
    seed
        Of poses and noise.
    """
    sensor = paper_sensor()
    rows: list[dict[str, Value]] = []
    for place, light in enumerate(Light):
        progress(place / len(Light), light.value)
        seen = see_targets(sensor, (light,), poses, [seed, 4, place])
        rows += [_row(light, method, seen, sensor) for method in Method]
    notes = (
        f"RMS in px of the points that were used, before and after correction; {poses} pictures "
        f"of {TARGET} a light, camera known, seed {seed}. A dot's truth is the centroid of its "
        "disc's picture, a stripe point's the place of the sheet across the stripe.",
    )
    return Table("Image deviations, RMS in px", rows, notes)


def _row(
    light: Light, method: Method, seen: Sequence[SeenTarget], truth: LaserSensor
) -> dict[str, Value]:
    names = ("dots before", "dots after", "stripe before", "stripe after")
    row: dict[str, Value] = {"light": light.value, "method": method.value}
    camera = truth.camera
    try:
        answer = calibrate(
            [each.view for each in seen],
            TARGET,
            width=camera.width,
            height=camera.height,
            camera=camera,
            method=method,
        )
    except CalibError:
        return row | dict.fromkeys(names, "refused")
    return row | dict(zip(names, _figures(seen, answer), strict=True))


def _figures(seen: Sequence[SeenTarget], answer: Calibration) -> list[Value]:
    """Return RMS of dots before and after, of stripe points before and after."""
    dots: list[FloatArray] = [np.empty((0, 2))]
    stripe: list[FloatArray] = [np.empty((0, 2))]
    # The stripe is the one that the solve settled on: in stray light it may be another line.
    for each, used, solved in zip(seen, answer.seen, answer.views, strict=True):
        if solved.dots is not None:
            dots.append(_dot_deviations_px(each, solved.dots))
        if solved.stripe is not None and used.stripe is not None:
            stripe.append(_stripe_deviations_px(each.scene, used.stripe, solved.stripe))
    return [
        float(np.sqrt(np.mean(column**2)))
        for part in (np.concatenate(dots), np.concatenate(stripe))
        for column in part.T
    ]


def _dot_deviations_px(seen: SeenTarget, solved: SolvedPoints) -> FloatArray:
    """Return lengths of the deviations before and after, shape (N, 2), of the used dots."""
    points = seen.view.points
    true_px = disc_centroids_px(seen.scene, points.points_mm(TARGET.pitch_mm))
    before = np.linalg.norm(points.centre_px - true_px, axis=1)
    after = np.linalg.norm(solved.corrected_px - true_px, axis=1)
    return np.column_stack([before, after])[solved.used]


def _stripe_deviations_px(
    scene: TargetScene, stripe: StripePoints, solved: SolvedPoints
) -> FloatArray:
    """Return deviations across the stripe before and after, shape (N, 2), of the used points."""
    before = across_from_sheet_px(scene, stripe.centre_px, stripe.normal)
    after = across_from_sheet_px(scene, solved.corrected_px, stripe.normal)
    return np.column_stack([before, after])[solved.used]


def disc_centroids_px(scene: TargetScene, centres_mm: FloatArray) -> FloatArray:
    """Return the true centroids of discs' pictures, shape (N, 2), by summing over the discs.

    Parameters
    ----------
    scene
        The scene, whose target tells the diameter.
    centres_mm
        Shape (N, 3), on the target.
    """
    ring = np.sqrt((np.arange(_RINGS) + 0.5) / _RINGS)
    angle = 2.0 * np.pi * (np.arange(_SPOKES) + 0.5) / _SPOKES
    within = np.stack([np.outer(ring, np.cos(angle)), np.outer(ring, np.sin(angle))], axis=-1)
    offset = 0.5 * (scene.target.diameter_mm or 0.0) * within.reshape(-1, 2)

    def seen(shift_mm: FloatArray) -> FloatArray:
        places = centres_mm[:, None, :] + np.pad(offset + shift_mm, ((0, 0), (0, 1)))
        in_cam = scene.cam_from_board.apply(places.reshape(-1, 3))
        return scene.sensor.camera.project(in_cam).reshape(len(centres_mm), -1, 2)

    # A piece of the disc counts by the area it takes in the picture.
    across, down = np.array([1e-3, 0.0]), np.array([0.0, 1e-3])
    one, other = seen(across) - seen(-across), seen(down) - seen(-down)
    area = np.abs(one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0])
    middle = seen(np.zeros(2))
    return np.asarray((area[..., None] * middle).sum(axis=1) / area.sum(axis=1)[:, None])


def across_from_sheet_px(
    scene: TargetScene, pixels_px: FloatArray, normal: FloatArray
) -> FloatArray:
    """Return how far pixels lie off the true stripe along a direction, shape (N,).

    The signed distance to the sheet of the board's point that a pixel shows changes evenly over
    the fractions of a pixel at hand: one step of the secant is exact to 1e-4 of it.
    """
    here = _off_sheet_mm(scene, pixels_px)
    slope = (
        _off_sheet_mm(scene, pixels_px + _STEP_PX * normal)
        - _off_sheet_mm(scene, pixels_px - _STEP_PX * normal)
    ) / (2.0 * _STEP_PX)
    return np.asarray(here / slope)


def _off_sheet_mm(scene: TargetScene, pixels_px: FloatArray) -> FloatArray:
    rays = scene.sensor.camera.rays(pixels_px)
    normal = scene.cam_from_board.rotation[:, 2]
    depth = normal @ scene.cam_from_board.translation_mm / (rays @ normal)
    return scene.sensor.plane.distance_mm(rays * depth[:, None])
