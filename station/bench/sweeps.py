"""The paper's two sweeps: noise of dots and noise of the stripe, every method beside the bound."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, Method, cramer_rao_bound
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.noisy_runs import NoisyRuns, rms_ratio
from station.bench.simulation import SENSOR, TARGET, Noise, Simulation
from station.progress import Progress
from station.tables import Table, Value

LEVELS_PX = tuple(0.5 * step for step in range(11))
_OTHER_PX = 0.5
_SOLVE_S = 0.17
_NAMES = ("a", "b", "c", "d")


@dataclass(frozen=True, slots=True)
class _Level:
    sweep: str
    level_px: float
    noise: Noise
    poses: int
    runs: int
    seed: int


@dataclass(frozen=True, slots=True, eq=False)
class _Scatter:
    """RMS errors of a level, and the Cramér-Rao bound of (a, b, c, d), shape (4,)."""

    runs: NoisyRuns
    bound: FloatArray


def bench_sweeps(
    progress: Progress,
    *,
    poses: int = 10,
    runs: int = 100,
    seed: int = 1,
    levels_px: Sequence[float] = LEVELS_PX,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Solve the paper's simulation at each level of noise, many times, by every method.

    Parameters
    ----------
    progress
        Told where the bench is.
    poses
        Poses of the target, the same in all runs.
    runs
        Draws of the noise a level.
    seed
        Of poses and noise.
    levels_px
        Levels of the noise that is swept.
    drawing
        Who does the draws.
    """
    began = time.monotonic()
    levels = [
        _Level(sweep, level, _noise_of(sweep, level), poses, runs, seed)
        for sweep in ("dots", "stripe")
        for level in levels_px
    ]
    scatters = drawing.map(_scatter, levels, seconds_each=runs * len(Method) * _SOLVE_S)
    rows = []
    for done, (level, scatter) in enumerate(zip(levels, scatters, strict=True), start=1):
        progress(done / len(levels), f"{level.sweep} {level.level_px:g} px")
        rows.append(_row(level, scatter))
    notes = (
        f"RMSE of the plane's coefficients (d in mm); {poses} poses of {TARGET}, one stripe point "
        f"a column of dots, camera known, {runs} runs a level, seed {seed}; the noise that is not "
        f"swept is {_OTHER_PX:g} px, noise of 0 is told as 0.001 px. "
        f"{time.monotonic() - began:.0f} s.",
        "bound: the Cramér-Rao bound. Over bound: root mean square over a, b, c, d of a method's "
        "RMSE over that of the best linear estimate, whose covariance is the bound and which sees "
        "the same noise: so the ratio does not carry the chance of the draws.",
    )
    return Table("RMSE of the light plane by noise, simulated", rows, notes)


def _noise_of(sweep: str, level_px: float) -> Noise:
    return Noise(level_px, _OTHER_PX) if sweep == "dots" else Noise(_OTHER_PX, level_px)


def _row(level: _Level, scatter: _Scatter) -> dict[str, Value]:
    row: dict[str, Value] = {"noise of": level.sweep, "level, px": level.level_px}
    for name, figure in zip(_NAMES, scatter.bound, strict=True):
        row[f"bound {name}"] = float(figure)
    runs = scatter.runs
    for method, rmse in runs.methods.items():
        for name, figure in zip(_NAMES, rmse, strict=True):
            row[f"{method} {name}"] = _or_refused(float(figure))
        row[f"{method} over bound"] = _or_refused(runs.over_bound(method))
    over_joint = rms_ratio(runs.methods[Method.PREPLANAR], runs.methods[Method.JOINT])
    row["preplanar over joint"] = _or_refused(over_joint)
    return row


def _or_refused(figure: float) -> Value:
    return figure if np.isfinite(figure) else "refused"


def _scatter(level: _Level) -> _Scatter:
    """Solve one level's runs by every method."""
    simulation = Simulation.drawn(level.poses, [level.seed, 1])
    rng = np.random.default_rng([level.seed, 2, level.sweep == "dots", round(10 * level.level_px)])
    runs = NoisyRuns.of(simulation, level.noise, rng, level.runs)
    # The bound owes to the sigmas alone, not to the draw.
    views = simulation.noisy(rng, level.noise).views
    bound = cramer_rao_bound(views, TARGET, SENSOR, simulation.poses)
    return _Scatter(runs, np.sqrt(np.diag(bound)[9:]))
