"""How far each point of each sensor is believed at a state, and the equations that follow."""

from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np

from calib.arrays import FloatArray
from calib.solving.joint.mixture import Mixture, correlated_run
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.rig.place import ChannelPlace, prior_equations
from calib.solving.rig.problem import Channel, RigProblem
from calib.solving.rig.unknowns import RigState

# The scales have settled when a step changes them by less than this part.
_SCALE_SETTLED = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class RigPlace:
    """A state with what it leaves of every channel."""

    state: RigState
    channels: tuple[ChannelPlace, ...]

    @classmethod
    def at(cls, problem: RigProblem, state: RigState) -> "RigPlace":
        """Compare all pictures with a state."""
        return cls(state, tuple(ChannelPlace.at(each, problem, state) for each in problem.channels))


@dataclass(frozen=True, slots=True, eq=False)
class RigBelief:
    """How dots and stripe of each sensor scatter, and the weights of each channel's points."""

    dots: tuple[Mixture, ...]
    stripe: tuple[Mixture, ...]
    dots_weight: tuple[FloatArray, ...]
    stripe_weight: tuple[FloatArray, ...]

    @classmethod
    def of(
        cls,
        problem: RigProblem,
        place: RigPlace,
        dots: tuple[Mixture, ...],
        stripe: tuple[Mixture, ...],
    ) -> "RigBelief":
        """Weigh the points of a place by how each sensor's scatter."""
        pairs = list(zip(problem.channels, place.channels, strict=True))
        return cls(
            dots,
            stripe,
            tuple(dots[each.sensor].weights(at.dots.residual) for each, at in pairs),
            tuple(
                np.where(each.stripe_in, stripe[each.sensor].weights(at.stripe.residual), 0.0)
                for each, at in pairs
            ),
        )

    @classmethod
    def from_medians(cls, problem: RigProblem, place: RigPlace) -> "RigBelief":
        """Judge from near: most points are good, and gross errors stand out.

        A stripe is judged against its own line, and those on the sheet of most of their kind are
        let in: judged against the sheet as calibrated, a sensor that was bent since would be taken
        for one whose stripes scatter.
        """
        dots, stripe = [], []
        for sensor in range(len(problem.priors)):
            own = problem.of_sensor(sensor)
            seen = [problem.channels[index].observations for index in own]
            dots.append(
                Mixture.from_median(
                    _residuals(problem, place, sensor)[0],
                    _stacked([each.dots.sigma_px for each in seen]),
                )
            )
            scatter = [
                _off_own_line(problem.channels[index], place.channels[index]) for index in own
            ]
            stripe.append(
                Mixture.from_median(
                    _stacked(scatter), _stacked([each.stripe.sigma_px for each in seen])
                )
            )
        judged = cls.of(
            problem,
            place,
            tuple(replace(each, settled=True) for each in dots),
            tuple(replace(each, settled=True) for each in stripe),
        )
        return replace(
            judged,
            stripe_weight=tuple(np.where(each.on_sheet, 1.0, 0.0) for each in problem.channels),
        )

    def settled_at(self, problem: RigProblem, place: RigPlace) -> "RigBelief":
        """Renew the scales by what this place leaves."""
        parts, total = self.equations(problem, place)
        covariance = total.covariance()
        dots, stripe = [], []
        for sensor, (of_dots, of_stripe) in enumerate(parts):
            dot_residual, stripe_residual = _residuals(problem, place, sensor)
            dot_weight, stripe_weight = self._weights(problem, sensor)
            # Parameters follow a run of like residuals as one: they spend a run for each freedom.
            spent = covariance.freedom_spent_on(of_stripe) * self.stripe[sensor].correlated
            dots.append(
                self.dots[sensor].updated(
                    dot_residual, dot_weight, covariance.freedom_spent_on(of_dots)
                )
            )
            stripe.append(self.stripe[sensor].updated(stripe_residual, stripe_weight, spent))
        return RigBelief.of(problem, place, tuple(dots), tuple(stripe))

    def held_at(self, problem: RigProblem, place: RigPlace) -> "RigBelief":
        """Weigh the points of this place anew, by the same scales."""
        return RigBelief.of(problem, place, self.dots, self.stripe)

    def with_runs_at(self, problem: RigProblem, place: RigPlace) -> "RigBelief":
        """Count stripe points that repeat their neighbours once."""
        stripe = []
        for sensor, mixture in enumerate(self.stripe):
            own = [problem.channels[index] for index in problem.of_sensor(sensor)]
            # Every picture is a group of its own.
            before = np.cumsum([0, *(each.observations.count for each in own)])
            group = [
                (each.observations.stripe.view + first)[each.stripe_in]
                for each, first in zip(own, before, strict=False)
            ]
            run = correlated_run(
                _residuals(problem, place, sensor)[1][:, 0],
                self._weights(problem, sensor)[1],
                np.concatenate(group),
                _stacked([each.observations.stripe.along_px[each.stripe_in] for each in own]),
            )
            stripe.append(replace(mixture, correlated=run))
        return RigBelief.of(problem, place, self.dots, tuple(stripe))

    def equations(
        self, problem: RigProblem, place: RigPlace
    ) -> tuple[list[tuple[NormalEquations, NormalEquations]], NormalEquations]:
        """Return the normal equations of each sensor's dots and stripe, and of all with priors."""
        total = prior_equations(problem, place.state)
        count, parts = len(problem.dot_sigma_mm), []
        for sensor in range(len(problem.priors)):
            of_dots, of_stripe = [], []
            for index in problem.of_sensor(sensor):
                channel, at = problem.channels[index], place.channels[index]
                dots_weight, stripe_weight = self.scaled_weights(problem, index)
                of_dots.append(at.dots_equations(channel, dots_weight, count))
                of_stripe.append(at.stripe_equations(channel, stripe_weight, count))
            parts.append((reduce(add, of_dots), reduce(add, of_stripe)))
            total = total + parts[-1][0] + parts[-1][1]
        return parts, total

    def scaled_weights(self, problem: RigProblem, channel: int) -> tuple[FloatArray, FloatArray]:
        """Return the weights of a channel's dots and stripe points over the scatter seen."""
        sensor = problem.channels[channel].sensor
        return (
            self.dots_weight[channel] / self.dots[sensor].variance,
            self.stripe_weight[channel] / self.stripe[sensor].variance,
        )

    def cost(self, problem: RigProblem, place: RigPlace) -> float:
        """Return the cost of a place under these weights."""
        squares = 2.0 * prior_equations(problem, place.state).cost
        for index, (channel, at) in enumerate(zip(problem.channels, place.channels, strict=True)):
            dots, stripe = self.dots[channel.sensor], self.stripe[channel.sensor]
            squares += (at.dots.residual**2).sum(axis=1) @ self.dots_weight[index] / dots.variance
            squares += at.stripe.residual[:, 0] ** 2 @ self.stripe_weight[index] / stripe.variance
        return float(squares) / 2.0

    def differs_from(self, other: "RigBelief") -> bool:
        """Tell whether the scales still move."""
        pairs = zip((*self.dots, *self.stripe), (*other.dots, *other.stripe), strict=True)
        return any(
            abs(mine.scale - theirs.scale) > _SCALE_SETTLED * theirs.scale for mine, theirs in pairs
        )

    def _weights(self, problem: RigProblem, sensor: int) -> tuple[FloatArray, FloatArray]:
        """Return the weights of a sensor's dots, and of its stripe points that take part."""
        own = problem.of_sensor(sensor)
        return (
            _stacked([self.dots_weight[index] for index in own]),
            _stacked([self.stripe_weight[i][problem.channels[i].stripe_in] for i in own]),
        )


def _residuals(problem: RigProblem, place: RigPlace, sensor: int) -> tuple[FloatArray, FloatArray]:
    """Return the residuals of a sensor's dots, and of its stripe points that take part."""
    own = problem.of_sensor(sensor)
    return (
        _stacked([place.channels[index].dots.residual for index in own]),
        _stacked([place.channels[i].stripe.residual[problem.channels[i].stripe_in] for i in own]),
    )


def _off_own_line(channel: Channel, at: ChannelPlace) -> FloatArray:
    """Return the residuals of stripe points on lines, less the line of each picture, (N, 1)."""
    table, residual = channel.observations.stripe, at.stripe.residual[:, 0].copy()
    for view in range(channel.observations.count):
        own = np.flatnonzero((table.view == view) & channel.on_sheet)
        if len(own):
            along = table.along_px[own] - table.along_px[own].mean()
            slope = along @ residual[own] / max(float(along @ along), 1e-9)
            residual[own] -= residual[own].mean() + slope * along
    return residual[channel.on_sheet, None]


def _stacked(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate(parts)
