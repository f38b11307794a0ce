"""The paper's two sweeps: noise of dots and noise of the stripe, every method beside the bound."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import CalibError, FloatArray, Method, calibrate, cramer_rao_bound
from station.bench.best_linear import BestLinear
from station.bench.simulation import (
    HEIGHT_PX,
    SENSOR,
    TARGET,
    WIDTH_PX,
    Drawn,
    Noise,
    Simulation,
)
from station.pipeline import map_on_all_cores
from station.progress import Progress
from station.tables import Table, Value

LEVELS_PX = tuple(0.5 * step for step in range(11))
_OTHER_PX = 0.5
_SOLVE_S = 0.12
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
    """RMS errors of (a, b, c, d), shape (4,) each; NaN for a method that refused a run."""

    bound: FloatArray
    linear: FloatArray
    methods: dict[Method, FloatArray]


def bench_sweeps(
    progress: Progress,
    *,
    poses: int = 10,
    runs: int = 100,
    seed: int = 1,
    levels_px: Sequence[float] = LEVELS_PX,
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
    """
    began = time.monotonic()
    levels = [
        _Level(sweep, level, _noise_of(sweep, level), poses, runs, seed)
        for sweep in ("dots", "stripe")
        for level in levels_px
    ]
    scatters: Iterator[_Scatter] = map_on_all_cores(
        _scatter, levels, count=len(levels), seconds_each=runs * len(Method) * _SOLVE_S
    )
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
    for method, rmse in scatter.methods.items():
        for name, figure in zip(_NAMES, rmse, strict=True):
            row[f"{method} {name}"] = _or_refused(float(figure))
        row[f"{method} over bound"] = _or_refused(_ratio(rmse, scatter.linear))
    joint = scatter.methods[Method.JOINT]
    row["preplanar over joint"] = _or_refused(_ratio(scatter.methods[Method.PREPLANAR], joint))
    return row


def _or_refused(figure: float) -> Value:
    return figure if np.isfinite(figure) else "refused"


def _ratio(one: FloatArray, other: FloatArray) -> float:
    return float(np.sqrt(np.mean((one / other) ** 2)))


def _scatter(level: _Level) -> _Scatter:
    """Solve one level's runs by every method."""
    simulation = Simulation.drawn(level.poses, [level.seed, 1])
    rng = np.random.default_rng([level.seed, 2, level.sweep == "dots", round(10 * level.level_px)])
    linear = BestLinear.of(simulation, level.noise)
    best: list[FloatArray] = []
    errors: dict[Method, list[FloatArray]] = {method: [] for method in Method}
    for _ in range(level.runs):
        drawn = simulation.noisy(rng, level.noise)
        best.append(linear.errors(drawn))
        for method in Method:
            errors[method].append(_errors(drawn, method))
    bound = cramer_rao_bound(drawn.views, TARGET, SENSOR, simulation.poses)
    return _Scatter(
        np.sqrt(np.diag(bound)[9:]),
        _rms(best),
        {method: _rms(found) for method, found in errors.items()},
    )


def _errors(drawn: Drawn, method: Method) -> FloatArray:
    try:
        found = calibrate(
            drawn.views,
            TARGET,
            width=WIDTH_PX,
            height=HEIGHT_PX,
            camera=SENSOR.camera,
            method=method,
        )
    except CalibError:
        return np.full(4, np.nan)
    return np.asarray(found.sensor.plane.coefficients - SENSOR.plane.coefficients)


def _rms(errors: list[FloatArray]) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=0)))
