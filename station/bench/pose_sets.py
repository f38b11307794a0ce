"""How far above the bound each method stays at 5 px of dot noise, over many sets of poses."""

from dataclasses import dataclass

import numpy as np

from calib import Method
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.noisy_runs import NoisyRuns
from station.bench.simulation import TARGET, Noise, Simulation
from station.progress import Progress
from station.tables import Table, Value

_NOISE = Noise(5.0, 0.5)
_RUN_S = 0.9
_QUANTILES = {"least": 0.0, "quarter": 0.25, "half": 0.5, "three quarters": 0.75, "most": 1.0}


@dataclass(frozen=True, slots=True)
class _PoseSet:
    seed: int
    place: int
    poses: int
    runs: int


def bench_pose_sets(
    progress: Progress,
    *,
    sets: int = 20,
    poses: int = 10,
    runs: int = 20,
    seed: int = 1,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Solve the paper's simulation for many sets of poses at its largest noise of the dots.

    Parameters
    ----------
    progress
        Told where the bench is.
    sets
        Sets of poses.
    poses
        Poses of the target in each.
    runs
        Draws of the noise for each.
    seed
        Of poses and noise.
    drawing
        Who does the draws.
    """
    tasks = [_PoseSet(seed, place, poses, runs) for place in range(sets)]
    found = drawing.map(_over_bound, tasks, seconds_each=runs * _RUN_S)
    ratios = []
    for done, ratio in enumerate(found, start=1):
        progress(done / sets, f"{done} of {sets} pose sets")
        ratios.append(ratio)
    rows = [_row(f"{method}", [ratio[method] for ratio in ratios]) for method in Method]
    over_joint = [ratio[Method.PREPLANAR] / ratio[Method.JOINT] for ratio in ratios]
    rows.append(_row("preplanar over joint", over_joint))
    note = (
        f"{sets} sets of {poses} poses of {TARGET}, {runs} runs each, camera known, seed {seed}; "
        f"{_NOISE.dots_px:g} px noise of dots, {_NOISE.stripe_px:g} px of the stripe. Root mean "
        "square over a, b, c, d of a method's RMSE over that of the best linear estimate; how "
        "far pre-planar stays above depends on the poses."
    )
    return Table("RMSE over the bound at 5 px of dot noise, by set of poses", rows, (note,))


def _row(name: str, ratios: list[float]) -> dict[str, Value]:
    quantiles = np.quantile(ratios, list(_QUANTILES.values()))
    return {"RMSE over bound": name, **dict(zip(_QUANTILES, quantiles.tolist(), strict=True))}


def _over_bound(task: _PoseSet) -> dict[Method, float]:
    simulation = Simulation.drawn(task.poses, [task.seed, 7, task.place])
    rng = np.random.default_rng([task.seed, 8, task.place])
    runs = NoisyRuns.of(simulation, _NOISE, rng, task.runs)
    return {method: runs.over_bound(method) for method in Method}
