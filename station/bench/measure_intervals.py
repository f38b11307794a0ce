"""Whether the 95 % intervals of wheel readings hold the truth 95 times of a hundred."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from calib import CameraModel, FloatArray, LaserSensor, LightPlane, RigidTransform, calibrate
from measure import OF_A_PROFILE, Mounting, Quantity, WheelFrame, measure_wheel, reference_profile
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.lights import TARGET, observe_light
from station.bench.wheel_stripes import PlacedWheel, StripeNoise
from station.bench.wheel_truths import errors_and_u95
from station.progress import Progress
from station.scenes import Light, WheelTruth, paper_sensor, trackside_mounting
from station.tables import Table, Value

ASKED_SHARE = (0.93, 0.97)
_POSES = 20
_MEASURE_S = 0.025
_STEP_MM = 20.0
_BEND_SHARE = 0.5
"""How wrong the pull of a bend is drawn to be; `measure` allows it as much, one sigma."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pass:
    """One wheel that passes, everything about it drawn from a seed."""

    covariance: FloatArray
    frames: int
    seed: tuple[int, ...]


def bench_intervals(
    progress: Progress,
    *,
    draws: Mapping[int, int] = MappingProxyType({1: 800, 5: 400}),
    seed: int = 1,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Draw everything a reading may be wrong by, as it is said to be, and count.

    Parameters
    ----------
    progress
        Told where the bench is.
    draws
        How many wheels, by the number of pictures of each, which are 20 mm apart.
    seed
        Of all draws.
    drawing
        Who does the draws.
    """
    covariance = calibrated_covariance(seed)
    rows: list[dict[str, Value]] = []
    unmeasured = 0
    for part, (count, wheels) in enumerate(draws.items()):
        progress(part / len(draws), f"{count} pictures a wheel")
        tasks = [_Pass(covariance, count, (seed, count, n)) for n in range(wheels)]
        answers = drawing.map(_errors_and_u95, tasks, seconds_each=_MEASURE_S * count)
        drawn = np.array(list(answers))
        unmeasured += int(np.isnan(drawn[:, :, 0]).all(axis=1).sum())
        rows += [
            interval_row(quantity, count, drawn[:, n]) for n, quantity in enumerate(OF_A_PROFILE)
        ]
    low, high = ASKED_SHARE
    fewest = min(draws.values())
    notes = (
        "Wheels S1002 and LMA, worn 0 to 8 mm, by geometry: noise and speckle of the stripe, pull "
        f"of its bends, sensor (the covariance of a calibration from {_POSES} rendered pictures), "
        "direction of the axle, height, radius and place all drawn from what is said of them.",
        f"Asked: {low} to {high}; luck alone moves a share of {fewest} by "
        f"{np.sqrt(0.0475 / fewest):.3f}, one sigma. Wheels without any reading: {unmeasured}.",
    )
    return Table("Truth inside u95", rows, notes)


def calibrated_covariance(seed: int) -> FloatArray:
    """Return what a calibration from rendered pictures in good light leaves open, (13, 13)."""
    sensor = paper_sensor()
    views, _ = observe_light(Light.GOOD, sensor, poses=_POSES, seed=seed)
    camera = sensor.camera
    return calibrate(views, TARGET, width=camera.width, height=camera.height).sensor.covariance


def interval_row(quantity: Quantity, frames: int, drawn: FloatArray) -> dict[str, Value]:
    """Return how often the truth lies within u95, of errors and u95 of a quantity, (N, 2)."""
    error, u95 = drawn[np.isfinite(drawn[:, 0])].T
    inside = float(np.mean(np.abs(error) <= u95))
    low, high = ASKED_SHARE
    return {
        "frames": frames,
        "quantity": quantity.value,
        "read": len(error),
        "inside u95": inside,
        "median u95, mm": float(np.median(u95)),
        "RMS error, mm": float(np.sqrt(np.mean(error**2))),
        "error over u95, RMS x 1.96": 1.96 * float(np.sqrt(np.mean((error / u95) ** 2))),
        "holds": low <= inside <= high,
    }


def _errors_and_u95(task: _Pass) -> FloatArray:
    """Return error and u95 of each quantity of one wheel, shape (Q, 2); NaN where not read."""
    rng = np.random.default_rng(task.seed)
    exact, nominal = paper_sensor(), trackside_mounting("left")
    mounting = Mounting(nominal)
    wheel = WheelTruth(
        reference=str(rng.choice(["S1002", "LMA"])),
        tread_wear_mm=float(rng.uniform(0.0, 8.0)),
        flange_wear_mm=float(rng.uniform(0.0, 4.0)),
        radius_mm=float(rng.normal(mounting.wheel_radius_mm, mounting.sigma_radius_mm)),
    )
    turn = rng.normal(size=3) * mounting.sigma_axle_direction_rad * [1.0, 0.0, 1.0]
    rig = RigidTransform.from_rotation_vector(turn, np.zeros(3)) @ nominal
    lifted, lateral = rng.normal(size=2) * [mounting.sigma_height_mm, 4.0]
    middle = rng.normal() * mounting.sigma_axle_x_mm
    noise, pull = StripeNoise(), 1.0 + _BEND_SHARE * float(rng.normal())
    frames = []
    for number in range(task.frames):
        x = middle + _STEP_MM * (number - (task.frames - 1) / 2.0)
        placed = PlacedWheel(wheel, exact, rig, float(x), float(lateral), float(lifted))
        frames.append(WheelFrame(placed.stripe(rng, noise, pull=pull), number, "drawn"))
    answer = measure_wheel(
        frames,
        _drawn_sensor(exact, task.covariance, rng),
        reference_profile(wheel.reference),
        mounting=mounting,
    )
    return np.array(errors_and_u95(answer, wheel, OF_A_PROFILE))


def _drawn_sensor(
    exact: LaserSensor, covariance: FloatArray, rng: np.random.Generator
) -> LaserSensor:
    nowhere = np.zeros(len(covariance))
    return sensor_beside(
        exact, rng.multivariate_normal(nowhere, covariance, check_valid="ignore"), covariance
    )


def sensor_beside(exact: LaserSensor, step: FloatArray, covariance: FloatArray) -> LaserSensor:
    """Return a sensor whose parameters, shape (13,), are off by a step, as it is said to be."""
    drawn = np.concatenate([exact.camera.parameters, exact.plane.coefficients]) + step
    camera = CameraModel.from_parameters(
        drawn[:9], width=exact.camera.width, height=exact.camera.height
    )
    return LaserSensor(camera, LightPlane.from_coefficients(drawn[9:]), covariance)
