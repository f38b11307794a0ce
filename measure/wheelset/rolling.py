"""The circle that rolls past a rig: radius and axle from where several sheets meet the tread."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from calib import FloatArray, IntArray
from measure.gauging.uncertainty import PICTURE_FLOOR_MM
from measure.mounting import Survey
from measure.place import WheelPlace
from measure.wheelset.agreement import Residuals

SIGMA_BOUNCE_MM = 0.05
"""How far the tread's height over the rail changes from one section of a wheel to another."""
# Where the axle stands along the rail is told by the sheets alone; this keeps the equations
# regular where they all look from straight below.
_ANYWHERE_MM = 1e3
_ITERATIONS = 20
_CONVERGED_MM = 1e-6
_RADIUS, _HEIGHT, _AXLES = 0, 1, 2


@dataclass(frozen=True, slots=True, eq=False)
class Sections:
    """Where sheets met the tape circle of one wheel, in shot after shot.

    Attributes
    ----------
    places_mm
        Shape (N, 2), rig (x, z).
    shot
        Shape (N,), which of the shots each is of, from 0 without gaps.
    single_mm
        Shape (N,), standard deviation along the radius.
    shared_mm
        Shape (N, 2, Q), motion for one sigma of each shared cause.
    """

    places_mm: FloatArray
    shot: IntArray
    single_mm: FloatArray
    shared_mm: FloatArray

    @classmethod
    def of(cls, places: Sequence[WheelPlace]) -> "Sections":
        """Gather the tread points of the places of one wheel."""
        treads = [tread for place in places for tread in place.treads]
        return cls(
            np.stack([tread.place_mm for tread in treads]),
            np.repeat(np.arange(len(places)), [len(place.treads) for place in places]),
            np.array([tread.single_mm for tread in treads]),
            np.stack([tread.shared_mm for tread in treads]),
        )

    @property
    def shots(self) -> int:
        """How many shots there are."""
        return int(self.shot[-1]) + 1


@dataclass(frozen=True, slots=True, eq=False)
class RollingCircle:
    """The circle of the tread and where it stood.

    Attributes
    ----------
    radius_mm, sigma_mm
        Radius at the tape circle, and its standard deviation.
    by_height_mm
        The part of `sigma_mm` that the survey of the height over the rail leaves.
    axle_x_mm
        Shape (M,), where the axle stood in each shot.
    apart_rad
        How far apart around the wheel the sheets meet it, at the most.
    residuals
        What the points lie off it.
    """

    radius_mm: float
    sigma_mm: float
    by_height_mm: float
    axle_x_mm: FloatArray
    apart_rad: float
    residuals: Residuals


def fit_rolling_circle(
    sections: Sections, survey: Survey, *, sigma_bounce_mm: float, nominal: bool
) -> RollingCircle | None:
    r"""Fit the circle that stands on the rail and passes through the points of all shots.

    Parameters
    ----------
    sections
        Of one wheel.
    survey
        Its nominal radius and `sigma_radius_mm`, `sigma_height_mm`, `sigma_axle_direction_rad`.
    sigma_bounce_mm
        By how much the height over the rail changes from shot to shot.
    nominal
        Whether the survey's radius and its sigma count as an observation.

    Returns
    -------
    RollingCircle or None
        None where the steps do not come to rest.

    Notes
    -----
    Unknown are the radius R, the height h of the tread over the rail's nominal top and, freely,
    the place :math:`x_i` of the axle in each shot. Each point gives

    .. math:: |p_{ik} - (x_i, R + h)| - R = 0

    with slopes :math:`-1 - u_z, -u_z, -u_x`, u the direction from the axle to the point. Its
    covariance holds the point's own noise, the shared causes, the height's change from shot to
    shot, and the slope of the rail against rig x, which is taken to be known as well as the
    axle's direction against rig y. Gauss-Newton, with h ~ N(0, sigma_height).

    Speed is not made use of, steady or known: where several sheets tell the radius it adds
    nothing, and of one sheet it leaves the radius open by millimetres.
    """
    prior = np.concatenate([
        [survey.wheel_radius_mm, 0.0],
        _start(sections, survey.wheel_radius_mm),
    ])
    known = np.full(len(prior), 1.0 / _ANYWHERE_MM**2)
    known[_RADIUS] = 1.0 / survey.sigma_radius_mm**2 if nominal else 0.0
    known[_HEIGHT] = 1.0 / survey.sigma_height_mm**2
    state = prior.copy()
    for _ in range(_ITERATIONS):
        outward, distance = _directions(sections, state)
        noise = _covariance(sections, outward, state, survey, sigma_bounce_mm)
        slopes = _slopes(sections, outward, len(state))
        residual = distance - state[_RADIUS]
        weighted = np.linalg.solve(noise, slopes)
        normal = slopes.T @ weighted + np.diag(known)
        step = np.linalg.solve(normal, weighted.T @ residual + known * (state - prior))
        state = state - step
        if not np.isfinite(state).all():
            return None
        if np.abs(step).max() < _CONVERGED_MM:
            break
    else:
        return None
    covariance = np.linalg.inv(normal)
    return RollingCircle(
        radius_mm=float(state[_RADIUS]),
        sigma_mm=float(np.sqrt(covariance[_RADIUS, _RADIUS])),
        by_height_mm=float(abs(covariance[_RADIUS, _HEIGHT]) / survey.sigma_height_mm),
        axle_x_mm=state[_AXLES:],
        apart_rad=_apart_rad(sections, outward),
        residuals=Residuals(residual, noise, slopes @ covariance @ slopes.T, sections.shot),
    )


def _directions(sections: Sections, state: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors from the axle to the points, shape (N, 2), and how far they are."""
    axles = np.column_stack([
        state[_AXLES:],
        np.full(sections.shots, state[_RADIUS] + state[_HEIGHT]),
    ])
    offset = sections.places_mm - axles[sections.shot]
    distance = np.linalg.norm(offset, axis=1)
    return offset / distance[:, None], distance


def _slopes(sections: Sections, outward: FloatArray, unknowns: int) -> FloatArray:
    """Return the derivative of distance minus radius by the unknowns."""
    slopes = np.zeros((len(outward), unknowns))
    slopes[:, _RADIUS] = -1.0 - outward[:, 1]
    slopes[:, _HEIGHT] = -outward[:, 1]
    slopes[np.arange(len(outward)), _AXLES + sections.shot] = -outward[:, 0]
    return slopes


def _covariance(
    sections: Sections,
    outward: FloatArray,
    state: FloatArray,
    survey: Survey,
    sigma_bounce_mm: float,
) -> FloatArray:
    """Return the covariance of the distances, shape (N, N), mm²."""
    shared = np.einsum("nj,njq->nq", outward, sections.shared_mm)
    together = sections.shot[:, None] == np.arange(sections.shots)
    bounce = together * outward[:, 1:] * sigma_bounce_mm
    climb = state[_AXLES:][sections.shot] * outward[:, 1] * survey.sigma_axle_direction_rad
    causes = np.column_stack([shared, bounce, climb])
    single = sections.single_mm**2 + PICTURE_FLOOR_MM**2
    return np.asarray(np.diag(single) + causes @ causes.T)


def _start(sections: Sections, radius_mm: float) -> FloatArray:
    """Return where a wheel of nominal radius stood in each shot.

    A point alone leaves two places, the wheel ahead of it and behind; of all combinations the one
    whose points agree best is taken.
    """
    x, z = sections.places_mm.T
    reach = np.sqrt(np.maximum(z * (2.0 * radius_mm - z), 0.0))
    starts = []
    for shot in range(sections.shots):
        mine = sections.shot == shot
        signs = np.array(list(product((-1.0, 1.0), repeat=int(mine.sum()))))
        places = x[mine] + signs * reach[mine]
        starts.append(places[np.argmin(np.ptp(places, axis=1))].mean())
    return np.array(starts)


def _apart_rad(sections: Sections, outward: FloatArray) -> float:
    # Straight up is where no tread is seen, so angles are counted from straight below.
    angle = np.arctan2(outward[:, 0], -outward[:, 1])
    return max(float(np.ptp(angle[sections.shot == shot])) for shot in range(sections.shots))
