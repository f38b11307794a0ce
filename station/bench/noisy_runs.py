"""Solving the paper's simulation again and again, each time with other noise."""

from dataclasses import dataclass

import numpy as np

from calib import CalibError, FloatArray, Method, calibrate
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


@dataclass(frozen=True, slots=True, eq=False)
class NoisyRuns:
    """RMS errors of (a, b, c, d), shape (4,) each; NaN for a method that refused a run.

    Attributes
    ----------
    linear
        Of the best linear estimate on the same noise: its covariance is the bound.
    methods
        Of each method.
    """

    linear: FloatArray
    methods: dict[Method, FloatArray]

    @classmethod
    def of(
        cls, simulation: Simulation, noise: Noise, rng: np.random.Generator, runs: int
    ) -> "NoisyRuns":
        """Solve so many draws of the noise by every method."""
        linear = BestLinear.of(simulation, noise)
        best: list[FloatArray] = []
        errors: dict[Method, list[FloatArray]] = {method: [] for method in Method}
        for _ in range(runs):
            drawn = simulation.noisy(rng, noise)
            best.append(linear.errors(drawn))
            for method in Method:
                errors[method].append(_errors(drawn, method))
        return cls(_rms(best), {method: _rms(found) for method, found in errors.items()})

    def over_bound(self, method: Method) -> float:
        """Return the root mean square, over a, b, c, d, of a method's RMSE over the linear one."""
        return rms_ratio(self.methods[method], self.linear)


def rms_ratio(one: FloatArray, other: FloatArray) -> float:
    """Return the root mean square of the ratios of two sets of errors, shape (4,) each."""
    return float(np.sqrt(np.mean((one / other) ** 2)))


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
