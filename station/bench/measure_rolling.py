"""What several pictures of a rolling wheel are worth, oblique ones among them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure import Mounting, Quantity, WheelFrame, measure_wheel, reference_profile
from station.bench.measure import SURVEYED_RAD, yawed_mounting
from station.bench.wheel_stripes import PlacedWheel, StripeNoise
from station.bench.wheel_truths import errors_and_u95
from station.pipeline import map_on_all_cores
from station.progress import Progress
from station.scenes import WheelTruth, paper_sensor
from station.tables import Table, Value

_STEP_MM = 20.0
_FRAMES = 5
_MEASURE_S = 0.25
_READ = (Quantity.FLANGE_HEIGHT, Quantity.FLANGE_THICKNESS_10)
_SINGLE = ("first alone", "middle alone", "last alone")
_TOGETHER = "all together"


@dataclass(frozen=True, slots=True)
class _Pass:
    """A wheel that rolls by: where the axle of the middle picture stands, and the sheet's yaw."""

    middle_mm: float
    yaw_deg: float
    seed: tuple[int, ...]


def bench_rolling(
    progress: Progress,
    *,
    wheels: int = 40,
    middles_mm: Sequence[float] = (0.0, 40.0),
    yaws_deg: Sequence[float] = (0.0, 3.0),
    seed: int = 1,
) -> Table:
    """Measure wheels from five pictures at steps of 20 mm, and from single ones of them.

    Parameters
    ----------
    progress
        Told where the bench is.
    wheels
        Of each pass, radii and heights drawn from what the survey says of them.
    middles_mm
        Places of the axle along the rail in the middle picture; at 0 its cut is radial.
    yaws_deg
        Angles of the sheet to the axle.
    seed
        Of all draws.
    """
    kinds = [(middle, yaw) for yaw in yaws_deg for middle in middles_mm]
    rows: list[dict[str, Value]] = []
    for done, (middle_mm, yaw_deg) in enumerate(kinds):
        progress(done / len(kinds), f"{middle_mm:g} mm, {yaw_deg:g} degrees")
        tasks = [_Pass(middle_mm, yaw_deg, (seed, done, number)) for number in range(wheels)]
        drawn = np.array([
            *map_on_all_cores(_errors_and_u95, tasks, count=wheels, seconds_each=_MEASURE_S)
        ])
        rows += [
            _row(middle_mm, yaw_deg, name, drawn[:, place])
            for place, name in enumerate((*_SINGLE, _TOGETHER))
        ]
    notes = (
        f"{wheels} wheels a pass by geometry, {_FRAMES} pictures {_STEP_MM:g} mm apart; radius "
        "and height drawn from the survey's sigmas (10 and 1 mm), direction and sensor exact.",
    )
    return Table("Pictures of a rolling wheel", rows, notes)


def _row(middle_mm: float, yaw_deg: float, name: str, drawn: FloatArray) -> dict[str, Value]:
    row: dict[str, Value] = {
        "middle at, mm": middle_mm,
        "yaw, degrees": yaw_deg,
        "pictures": name,
        "read": f"{np.isfinite(drawn[:, 0, 0]).sum()} of {len(drawn)}",
    }
    for place, quantity in enumerate(_READ):
        error, u95 = drawn[np.isfinite(drawn[:, place, 0]), place].T
        row[f"{quantity} RMS, mm"] = float(np.sqrt(np.mean(error**2)))
        row[f"{quantity} mean, mm"] = float(error.mean())
        row[f"{quantity} u95, mm"] = float(np.median(u95))
    return row


def _errors_and_u95(task: _Pass) -> FloatArray:
    """Return errors and u95 of single pictures and of all, shape (4, quantities, 2)."""
    rng = np.random.default_rng(task.seed)
    rig = yawed_mounting(task.yaw_deg)
    mounting = Mounting(rig, sigma_axle_direction_rad=SURVEYED_RAD)
    wheel = WheelTruth(
        tread_wear_mm=float(rng.uniform(0.0, 8.0)),
        flange_wear_mm=float(rng.uniform(0.0, 4.0)),
        radius_mm=float(rng.normal(mounting.wheel_radius_mm, mounting.sigma_radius_mm)),
    )
    lifted = float(rng.normal(0.0, mounting.sigma_height_mm))
    frames = []
    for number in range(_FRAMES):
        x = task.middle_mm + _STEP_MM * (number - (_FRAMES - 1) / 2.0)
        placed = PlacedWheel(wheel, paper_sensor(), rig, x, 0.0, lifted)
        frames.append(WheelFrame(placed.stripe(rng, StripeNoise()), number, "drawn"))
    chosen = ([frames[0]], [frames[_FRAMES // 2]], [frames[-1]], frames)
    return np.array([_one(wheel, some, mounting) for some in chosen])


def _one(
    wheel: WheelTruth, frames: Sequence[WheelFrame], mounting: Mounting
) -> list[tuple[float, float]]:
    answer = measure_wheel(
        frames, paper_sensor(), reference_profile(wheel.reference), mounting=mounting
    )
    return errors_and_u95(answer, wheel, _READ)
