"""Is what a calibration says of its own uncertainty true: the paper's simulation, drawn often."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import CalibError, FloatArray, Method, calibrate
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.simulation import HEIGHT_PX, SENSOR, TARGET, WIDTH_PX, Noise, Simulation
from station.progress import Progress
from station.tables import Table, Value

_NOISE = Noise(dots_px=0.1, stripe_px=0.1)
_DRAW_S = 0.5
_U95 = 1.96


@dataclass(frozen=True, slots=True)
class _Draw:
    """One draw of the noise."""

    seed: int
    poses: int
    number: int


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """Of one draw and method: error and told sigma of (a, b, c, d), shape (4,); NaN if refused."""

    method: Method
    error: FloatArray
    sigma: FloatArray


def bench_paper_draws(
    progress: Progress,
    *,
    draws: int = 200,
    poses: int = 10,
    seed: int = 1,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Calibrate the paper's simulation with other noise each time, by every method.

    Parameters
    ----------
    progress
        Told where the bench is.
    draws
        Of the noise.
    poses
        Of the target, the same in all draws.
    seed
        Of poses and noise.
    drawing
        Who does the draws.
    """
    tasks = [_Draw(seed, poses, number) for number in range(draws)]
    found: list[_Drawn] = []
    for drawn in drawing.map(_drawn, tasks, seconds_each=_DRAW_S):
        found += drawn
        done = len(found) // len(Method)
        progress(done / draws, f"draw {done} of {draws}")
    rows = [_row(method, [one for one in found if one.method is method]) for method in Method]
    notes = (
        f"{draws} draws of {_NOISE.dots_px:g} px noise on every dot and stripe point, {poses} "
        f"poses of {TARGET}, camera known, seed {seed}. Told: what each calibration says of "
        "itself. Inside: how often the true plane's a, b, c, d lie within 1.96 told sigma.",
    )
    return Table("Scatter of the light plane, and what calibrations tell of it", rows, notes)


def _drawn(draw: _Draw) -> list[_Drawn]:
    simulation = Simulation.drawn(draw.poses, draw.seed)
    return [_solved(simulation, method, draw) for method in Method]


def _solved(simulation: Simulation, method: Method, draw: _Draw) -> _Drawn:
    # Every method sees the same noise.
    views = simulation.noisy(np.random.default_rng([draw.seed, draw.number]), _NOISE).views
    try:
        sensor = calibrate(
            views, TARGET, width=WIDTH_PX, height=HEIGHT_PX, camera=SENSOR.camera, method=method
        ).sensor
    except CalibError:
        return _Drawn(method, np.full(4, np.nan), np.full(4, np.nan))
    error = sensor.plane.coefficients - SENSOR.plane.coefficients
    return _Drawn(method, error, np.sqrt(np.diag(sensor.covariance)[-4:]))


def _row(method: Method, drawn: Sequence[_Drawn]) -> dict[str, Value]:
    errors = np.array([one.error for one in drawn])
    sigmas = np.array([one.sigma for one in drawn])
    solved = np.isfinite(errors).all(axis=1)
    errors, sigmas = errors[solved], sigmas[solved]
    return {
        "method": str(method),
        "draws solved": int(solved.sum()),
        "normal, RMSE, mrad": 1e3 * float(np.sqrt((errors[:, :3] ** 2).sum(axis=1).mean())),
        "told, mrad": 1e3 * float(np.sqrt((sigmas[:, :3] ** 2).sum(axis=1).mean())),
        "d, RMSE, mm": float(np.sqrt((errors[:, 3] ** 2).mean())),
        "told, mm": float(np.sqrt((sigmas[:, 3] ** 2).mean())),
        "inside": float((np.abs(errors) <= _U95 * sigmas).mean()),
    }
