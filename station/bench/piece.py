"""What a reference piece shows of a sensor that has drifted since its calibration."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import LaserSensor
from measure import Piece, PieceJudgement, PieceVerdict, judge_piece
from station.bench.piece_drifts import DRIFTS, NO_DRIFT, PIECES, Drift
from station.bench.piece_stripes import Held, calibrated_sensor, rendered_stripe
from station.pipeline import map_on_all_cores
from station.progress import Progress
from station.tables import Table, Value

_PLACEMENTS = 5
_RUN_S = 1.5
# One-sided: what exceeds its limit by this many sigmas is found in 95 % of cases.
_FOUND_95 = 1.645
_WAYS = ("one picture", f"{_PLACEMENTS} placements", "held, since")


def bench_piece(progress: Progress, *, runs: int = 20, seed: int = 1) -> Table:
    """Show pieces to sensors that have drifted since their calibration.

    Parameters
    ----------
    progress
        Told where the bench is.
    runs
        How often each.
    seed
        Of placements, speckle and noise.
    """
    calibrated = calibrated_sensor(20, seed)
    tasks = [
        _Trial(piece, drift, way, calibrated, runs, seed)
        for piece in PIECES
        for drift in DRIFTS
        for way in _WAYS
        if way != _WAYS[2] or piece.held_u95_mm is not None
    ]
    answers: Iterator[dict[str, Value]] = map_on_all_cores(
        _tried, tasks, count=len(tasks), seconds_each=runs * _RUN_S
    )
    rows = []
    for done, row in enumerate(answers, start=1):
        progress(done / len(tasks), f"{row['piece']}, {row['drift']}")
        rows.append(row)
    notes = (
        f"Rendered, good light, {runs} runs a row, seed {seed}; calibrated on 20 pictures of the "
        "target, camera and all. Found: called drifted; of no drift that is a false alarm, 1 % at "
        "most is meant. Found in 95 % from: the drift that would be, as the deviations grow in "
        "proportion to it.",
        f"{_WAYS[1]}: taken together. {_WAYS[2]}: one picture against one taken before the drift, "
        "the piece in a holder that keeps it to 0.01 mm (95 %).",
    )
    return Table("Drifts that a reference piece shows", rows, notes)


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    piece: Piece
    drift: Drift
    way: str
    calibrated: LaserSensor
    runs: int
    seed: int


def _tried(trial: _Trial) -> dict[str, Value]:
    judged = [_judged(trial, run) for run in range(trial.runs)]
    found = np.mean([one.verdict is PieceVerdict.DRIFTED for one in judged])
    unsaid = np.mean([one.verdict is PieceVerdict.UNKNOWN for one in judged])
    sizes, name = _sizes_to_find(judged)
    drift = trial.drift
    shown = "" if drift is NO_DRIFT or not sizes else f"{sizes * drift.size:.2g} {drift.unit}"
    return {
        "piece": trial.piece.name,
        "drift": f"{drift.name} {drift.size:g} {drift.unit}" if drift.unit else drift.name,
        "pictures": trial.way,
        "found, %": float(100.0 * found),
        "cannot say, %": float(100.0 * unsaid),
        "found in 95 % from": shown,
        "by": name if shown else "",
    }


def _judged(trial: _Trial, run: int) -> PieceJudgement:
    now = trial.drift.drifted(trial.calibrated, 1.0)
    count = _PLACEMENTS if trial.way == _WAYS[1] else 1
    rng = np.random.default_rng([trial.seed, run])
    held = [Held.drawn(rng) for _ in range(count)]
    stripes = [
        (
            f"picture {place}",
            rendered_stripe(
                trial.piece, now, one, 10 * run + place, believed=trial.calibrated, shot=1
            ),
        )
        for place, one in enumerate(held)
    ]
    earlier = None
    if trial.way == _WAYS[2]:
        before = rendered_stripe(trial.piece, trial.calibrated, held[0], 10 * run, shot=2)
        first = judge_piece([("before", before)], trial.calibrated, trial.piece)
        earlier = first.readings[0].place
    return judge_piece(stripes, trial.calibrated, trial.piece, earlier=earlier)


def _sizes_to_find(judged: Sequence[PieceJudgement]) -> tuple[float, str]:
    """Return how many sizes of the drift would be found in 95 %, and by which deviation."""
    best, by = np.inf, ""
    names = dict.fromkeys(one.name for judgement in judged for one in judgement.deviations)
    for name in names:
        same = [
            (one, judgement.coverage_factor)
            for judgement in judged
            for one in judgement.deviations
            if one.name == name
        ]
        shift = abs(float(np.mean([one.off_mm for one, _ in same])))
        needed = np.mean([one.u95_mm * (factor + _FOUND_95 / 1.96) for one, factor in same])
        if shift > 0.0 and needed / shift < best:
            best, by = float(needed) / shift, name
    return (best, by) if np.isfinite(best) else (0.0, "")
