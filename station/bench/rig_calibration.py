"""How long the solve of a rig takes, and how true it is, by the number of showings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from calib import (
    POSE_PARAMETERS,
    FloatArray,
    LaserSensor,
    Rig,
    RigidTransform,
    RigShowing,
    Target,
    calibrate_rig,
    compare_placings,
)
from station.bench.rig_points import PointRig
from station.bench.simulation import Noise
from station.bench.timing import CoreTime
from station.progress import Progress
from station.tables import Table, Value

_TARGET = Target.parse("dots:7x8:12")
_NOISE = Noise(0.05, 0.1)
_SIGMA_BOARD_MM = 0.02
_POSES, _STRIPE_POINTS = 20, 200
_ANCHOR, _OTHER = "inner", "outer"
_TIMED_RUNS = 7
_RUNS_A_TARGET = 10
"""Target and placings are drawn anew after so many runs."""
_EVERY = 20
"""Of the stripe points of a picture, as many are compared."""


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """Of one run, how far the other sensor's points lie from the truth, and are said to, mm."""

    miss_mm: FloatArray
    sigma_mm: FloatArray
    pose_chi_square: float


def bench_rig_calibration(
    progress: Progress,
    *,
    sizes: Sequence[int] = (4, 6, 8, 12, 24),
    runs: int = 100,
    seed: int = 1,
) -> Table:
    """Calibrate a rig from simulated points of few showings and of many.

    Parameters
    ----------
    progress
        Told where the bench is.
    sizes
        Numbers of showings.
    runs
        Draws of sensors, boards' errors and noise for each.
    seed
        Of all draws.
    """
    rows = []
    for done, size in enumerate(sizes):
        progress(done / len(sizes), f"{size} showings")
        rows.append(_row(size, runs, seed))
    note = (
        f"Points of {_TARGET}, one board for each of two sensors as beside the track, "
        f"{_STRIPE_POINTS} stripe points a picture; noise {_NOISE.dots_px:g} px of dots and "
        f"{_NOISE.stripe_px:g} px of the stripe; boards printed with errors of {_SIGMA_BOARD_MM:g} "
        f"mm along each axis, the same in all showings. {runs} runs: in each the sensors are drawn "
        f"anew from what a calibration of {_POSES} poses leaves open, with errors and noise. "
        "Miss: of points that the outer sensor locates on its lit sheet, from the truth, seen from "
        "the inner camera. Chi square: of the pose, 6 where its covariance is true. Seconds of one "
        f"core: median of {_TIMED_RUNS} solves."
    )
    return Table("Calibration of a rig by the number of showings", rows, (note,))


def _row(size: int, runs: int, seed: int) -> dict[str, Value]:
    rng = np.random.default_rng([seed, size])
    rig = PointRig.trackside(rng, _TARGET, _NOISE, poses=_POSES, stripe_points=_STRIPE_POINTS)
    found = []
    for run in range(runs):
        if run % _RUNS_A_TARGET == 0:
            body, held = rig.held(rng, size)
        truth = rig.drawn_truth(rng)
        showings = rig.showings(rng, truth, body, held, _SIGMA_BOARD_MM)
        found.append(_run(rig, truth, showings))
    taken = CoreTime.of(partial(_solved, rig, showings), runs=_TIMED_RUNS)
    miss, sigma = (
        float(np.sqrt(np.mean([np.mean(each**2) for each in parts])))
        for parts in ([run.miss_mm for run in found], [run.sigma_mm for run in found])
    )
    return {
        "showings": size,
        "s": taken.median_s,
        "miss, mm RMS": miss,
        "predicted, mm": sigma,
        "ratio": miss / sigma,
        "chi square of the pose": float(np.mean([run.pose_chi_square for run in found])),
    }


def _solved(rig: PointRig, showings: Sequence[RigShowing]) -> Rig:
    boards = dict.fromkeys(rig.known, rig.target)
    return calibrate_rig(
        showings, rig.known, boards, anchor=_ANCHOR, sigma_board_mm=_SIGMA_BOARD_MM
    ).rig


def _run(rig: PointRig, truth: Mapping[str, LaserSensor], showings: Sequence[RigShowing]) -> _Run:
    answer, exact = _solved(rig, showings), rig.exact(truth)
    seen = [showing.views[_OTHER][1].stripe for showing in showings]
    pixels = np.concatenate([each.centre_px[::_EVERY] for each in seen if each is not None])
    compared = compare_placings(answer, exact, sensor=_OTHER, anchor=_ANCHOR, pixels_px=pixels)
    base = exact[_ANCHOR].rig_from_camera.inverse()
    true, pose = base @ exact[_OTHER].rig_from_camera, answer[_OTHER].rig_from_camera
    turn = RigidTransform(pose.rotation @ true.rotation.T, np.zeros(3)).rotation_vector
    error = np.concatenate([turn, pose.translation_mm - true.translation_mm])
    columns = answer.columns(_OTHER)[-len(POSE_PARAMETERS) :]
    covariance = answer.covariance[np.ix_(columns, columns)]
    return _Run(
        compared.difference_mm, compared.sigma_mm, float(error @ np.linalg.solve(covariance, error))
    )
