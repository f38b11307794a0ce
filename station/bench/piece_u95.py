"""Whether the uncertainties of a reference piece's dimensions are true, over drawn sensors."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import CameraModel, FloatArray, LaserSensor, LightPlane
from measure import judge_piece
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.piece_drifts import profile_piece
from station.bench.piece_stripes import Held, calibrated_sensor, simulated_stripe
from station.progress import Progress
from station.tables import Table, Value

# Noise of the points, px, and by how much the calibration is in greater doubt than it was: the
# points tell most of the uncertainty, or both, or the sensor.
_CASES = ((0.06, 1.0), (0.03, 5.0), (0.01, 20.0))
_JUDGE_S = 0.3


def bench_piece_u95(
    progress: Progress,
    *,
    pictures: int = 20,
    runs: int = 240,
    seed: int = 1,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Hold the uncertainties of a piece's dimensions against their scatter over drawn sensors.

    Parameters
    ----------
    progress
        Told where the bench is.
    pictures
        Of the calibration whose covariance is taken.
    runs
        Sensors drawn from the covariance.
    seed
        Of sensors, placements and noise.
    drawing
        Who does the draws.
    """
    progress(0.0, "calibrating")
    calibrated = calibrated_sensor(pictures, seed)
    tasks = [
        _Draw(_in_doubt(calibrated, doubt), noise, [seed, run])
        for noise, doubt in _CASES
        for run in range(runs)
    ]
    seen: list[_Deviations] = []
    for answer in drawing.map(_drawn, tasks, seconds_each=_JUDGE_S):
        seen.append(answer)
        progress(len(seen) / len(tasks), f"sensor {len(seen)} of {len(tasks)}")
    rows = [
        row
        for place, (noise, doubt) in enumerate(_CASES)
        for row in _rows(noise, doubt, seen[place * runs : (place + 1) * runs])
    ]
    notes = (
        f"Points, not pictures: {runs} sensors a case drawn from the covariance of a calibration "
        f"on {pictures} pictures, its sigmas so many times as large, each shown "
        f"{profile_piece().name} elsewhere; seed {seed}. "
        "Within: share of deviations no larger than their u95; 95 % is meant, and the figure of "
        f"one dimension is known to {100 * 1.96 * np.sqrt(0.05 * 0.95 / runs):.1f} %.",
    )
    return Table("Uncertainty of a reference piece's dimensions", rows, notes)


@dataclass(frozen=True, slots=True, eq=False)
class _Draw:
    calibrated: LaserSensor
    noise_px: float
    seed: Sequence[int]


_Deviations = list[tuple[str, float, float]]
"""Name, deviation and u95 of each."""


def _drawn(draw: _Draw) -> _Deviations:
    """Let a sensor measure that is off as its covariance says."""
    rng = np.random.default_rng(draw.seed)
    piece = profile_piece()
    truth = _sensor_drawn(draw.calibrated, rng)
    stripe = simulated_stripe(piece, truth, Held.drawn(rng), rng, draw.noise_px)
    judged = judge_piece([("drawn", stripe)], draw.calibrated, piece, temperature_c=20.0)
    answer = [(one.name, one.off_mm, one.u95_mm) for one in judged.deviations]
    return answer + [("profile", one.off_mm, one.u95_mm) for one in judged.profile]


def _in_doubt(sensor: LaserSensor, times: float) -> LaserSensor:
    return LaserSensor(sensor.camera, sensor.plane, times**2 * sensor.covariance)


def _sensor_drawn(sensor: LaserSensor, rng: np.random.Generator) -> LaserSensor:
    camera = sensor.camera
    centre = np.concatenate([camera.parameters, sensor.plane.coefficients])
    drawn = centre + _root(sensor.covariance) @ rng.normal(size=len(centre))
    return LaserSensor.exact(
        CameraModel.from_parameters(drawn[:9], width=camera.width, height=camera.height),
        LightPlane.from_coefficients(drawn[9:]),
    )


def _root(covariance: FloatArray) -> FloatArray:
    """Return a matrix whose square, by its transpose, is the covariance."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    return np.asarray(scale[:, None] * vectors * np.sqrt(values.clip(min=0.0)))


def _rows(
    noise_px: float, doubt: float, answers: Sequence[_Deviations]
) -> Iterator[dict[str, Value]]:
    by_name: dict[str, list[tuple[float, float]]] = {}
    for answer in answers:
        for name, off, u95 in answer:
            by_name.setdefault(name, []).append((off, u95))
            if name != "profile":
                by_name.setdefault("all dimensions", []).append((off, u95))
    for name, pairs in by_name.items():
        off, u95 = np.array(pairs).T
        yield {
            "noise, px": noise_px,
            "sensor's doubt": doubt,
            "dimension": name,
            "deviations": len(off),
            "RMS, mm": float(np.sqrt(np.mean(off**2))),
            "u95 / 1.96, mm": float(np.sqrt(np.mean((u95 / 1.96) ** 2))),
            "within, %": float(100.0 * np.mean(np.abs(off) <= u95)),
        }
