"""How long solving takes, and how another solver does on the same points."""

import contextlib
from collections.abc import Callable, Sequence

import numpy as np

from calib import (
    CalibError,
    Calibration,
    CameraModel,
    FloatArray,
    Method,
    Picture,
    View,
    calibrate,
    cramer_rao_bound,
    observe_target,
)
from station.bench.paper_pictures import TARGET as LED_TARGET
from station.bench.peers import NOT_INSTALLED, peer
from station.bench.peers_calibration import MODULE, peer_plane
from station.bench.simulation import HEIGHT_PX, SENSOR, TARGET, WIDTH_PX, Noise, Simulation
from station.bench.timing import CoreTime
from station.progress import Progress
from station.scenes import Light, paper_sensor, target_scenes
from station.tables import Table, Value

_NOISE = Noise(0.1, 0.1)
_TIMED_RUNS = 7
_PICTURES_A_LIGHT = 2
_SOLVER_COLUMNS = ("a", "b", "c", "d", "s", "spread, s")


def bench_solving(
    progress: Progress, *, sizes: Sequence[int] = (20, 200), runs: int = _TIMED_RUNS, seed: int = 1
) -> Table:
    """Time the solve of simulated points by every method, and seeing in rendered pictures.

    Parameters
    ----------
    progress
        Told where the bench is.
    sizes
        Numbers of poses to solve.
    runs
        Timed runs of each.
    seed
        Of poses and noise.
    """
    rows: list[dict[str, Value]] = []
    for place, size in enumerate(sizes):
        progress(place / (len(sizes) + 1), f"{size} poses")
        views = Simulation.drawn(size, [seed, 3]).noisy(np.random.default_rng(seed), _NOISE).views
        for method in Method:
            for camera in (SENSOR.camera, None):
                solve = _solve_of(views, method, camera)
                knowledge = "estimated" if camera is None else "known"
                what = f"{size} poses, {method}, camera {knowledge}"
                rows.append(_time_row(what, CoreTime.of(solve, runs=runs), size))
    progress(len(sizes) / (len(sizes) + 1), "pictures")
    rows.append(_pictures_row(runs, seed))
    note = (
        f"Seconds of one core: median of {runs} runs, and the distance between their quartiles. "
        f"Poses: {TARGET}, {TARGET.cols} stripe points each. Pictures: {WIDTH_PX} x {HEIGHT_PX} "
        f"px of {LED_TARGET}, {_PICTURES_A_LIGHT} in each light: dots and stripe found, then "
        "solved jointly."
    )
    return Table("Time of a calibration", rows, (note,))


def _solve_of(
    views: Sequence[View], method: Method, camera: CameraModel | None
) -> Callable[[], object]:
    return lambda: calibrate(
        views, TARGET, width=WIDTH_PX, height=HEIGHT_PX, camera=camera, method=method
    )


def _time_row(what: str, taken: CoreTime, count: int) -> dict[str, Value]:
    return {
        "work": what,
        "s": taken.median_s,
        "spread, s": taken.spread_s,
        "ms each": 1e3 * taken.median_s / count,
    }


def _pictures_row(runs: int, seed: int) -> dict[str, Value]:
    """Time from pictures in all lights to the plane, the pictures one after the other."""
    sensor, rng = paper_sensor(), np.random.default_rng([seed, 4])
    scenes = target_scenes(rng, sensor, LED_TARGET, [*Light] * _PICTURES_A_LIGHT)
    pictures = [scene.render(rng) for scene in scenes]
    what = f"{len(pictures)} pictures to calibration, camera known"
    taken = CoreTime.of(lambda: _calibrate_pictures(pictures, sensor.camera), runs=runs)
    return _time_row(what, taken, len(pictures))


def _calibrate_pictures(pictures: Sequence[Picture], camera: CameraModel) -> Calibration:
    views = []
    for place, picture in enumerate(pictures):
        # A light in which the target is lost costs its time as well.
        with contextlib.suppress(CalibError):
            views.append(observe_target(picture, LED_TARGET, name=f"picture {place}"))
    return calibrate(views, LED_TARGET, width=camera.width, height=camera.height, camera=camera)


def bench_solvers(progress: Progress, *, poses: int = 20, runs: int = 30, seed: int = 1) -> Table:
    """Solve the same points by `joint` and by the peer, the camera estimated by both.

    Parameters
    ----------
    progress
        Told where the bench is.
    poses
        Poses of the target, the same in all runs.
    runs
        Draws of the noise.
    seed
        Of poses and noise.
    """
    simulation, rng = Simulation.drawn(poses, [seed, 5]), np.random.default_rng([seed, 6])
    draws = [simulation.noisy(rng, _NOISE).views for _ in range(runs)]
    solvers: dict[str, Callable[[Sequence[View]], FloatArray] | None] = {
        "treadline, joint": _joint_plane,
        "vision-calibration": _peer_solver(),
    }
    rows = []
    for place, (name, solve) in enumerate(solvers.items()):
        progress(place / len(solvers), name)
        rows.append({"solver": name, **_solver_figures(solve, draws)})
    note = (
        f"RMSE of the plane (d in mm) over {runs} draws of noise of {_NOISE.dots_px:g} px on dots "
        f"and stripe; {poses} poses of {TARGET}, {TARGET.cols} stripe points each, the same for "
        "both. Camera estimated from the same points: the peer cannot hold a known one; it "
        "estimates p1 and p2 as well. Bound: Cramér-Rao, fx, fy, cx, cy, k1, k2 unknown."
    )
    return Table("Solvers on the same points", [*rows, _bound_row(simulation, draws[0])], (note,))


def _joint_plane(views: Sequence[View]) -> FloatArray:
    found = calibrate(views, TARGET, width=WIDTH_PX, height=HEIGHT_PX)
    return found.sensor.plane.coefficients


def _peer_solver() -> Callable[[Sequence[View]], FloatArray] | None:
    module = peer(MODULE)
    return None if module is None else lambda views: peer_plane(module, views, TARGET)


def _solver_figures(
    solve: Callable[[Sequence[View]], FloatArray] | None, draws: Sequence[Sequence[View]]
) -> dict[str, Value]:
    if solve is None:
        return dict.fromkeys(_SOLVER_COLUMNS, NOT_INSTALLED)
    errors = [solve(views) - SENSOR.plane.coefficients for views in draws]
    taken = CoreTime.of(lambda: solve(draws[0]), runs=_TIMED_RUNS)
    figures = [*np.sqrt(np.mean(np.square(errors), axis=0)), taken.median_s, taken.spread_s]
    return dict(zip(_SOLVER_COLUMNS, map(float, figures), strict=True))


def _bound_row(simulation: Simulation, views: Sequence[View]) -> dict[str, Value]:
    bound = cramer_rao_bound(views, TARGET, SENSOR, simulation.poses, free_camera=range(6))
    sigma = np.sqrt(np.diag(bound)[9:]).tolist()
    return {"solver": "bound", **dict(zip(_SOLVER_COLUMNS, [*sigma, "", ""], strict=True))}
