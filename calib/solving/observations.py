"""The points of many views as flat tables, in the form a solver works on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.target import Target
from calib.views import StripePoints, View


@dataclass(frozen=True, slots=True, eq=False)
class DotTable:
    """Target points of all views, sorted by view.

    Attributes
    ----------
    view
        Shape (N,), index of the view.
    board_mm
        Shape (N, 3), places on the target.
    seen_px, sigma_px
        Shape (N, 2), observed and its standard deviations along u and v.
    """

    view: IntArray
    board_mm: FloatArray
    seen_px: FloatArray
    sigma_px: FloatArray

    def __len__(self) -> int:
        return len(self.view)


@dataclass(frozen=True, slots=True, eq=False)
class StripeTable:
    """Stripe points of all views, sorted by view.

    Attributes
    ----------
    view
        Shape (N,), index of the view.
    seen_px, normal
        Shape (N, 2), observed, and the unit direction across the stripe.
    sigma_px
        Shape (N,), standard deviation along `normal`.
    along_px
        Shape (N,), place along the stripe of its view.
    """

    view: IntArray
    seen_px: FloatArray
    normal: FloatArray
    sigma_px: FloatArray
    along_px: FloatArray

    def __len__(self) -> int:
        return len(self.view)


@dataclass(frozen=True, slots=True, eq=False)
class Observations:
    """What M views have seen of a target and of a stripe on it.

    Attributes
    ----------
    count
        M.
    dots, stripe
        The points.
    radius_mm
        Radius of a dot, given or seen; 0 where it is unknown or the points are corners.
    """

    count: int
    dots: DotTable
    stripe: StripeTable
    radius_mm: float

    @classmethod
    def of(cls, views: Sequence[View], target: Target) -> "Observations":
        """Flatten views; a view without a stripe gives dots only."""
        dots = DotTable(
            view=_index([len(view.points) for view in views]),
            board_mm=_stack([view.points.points_mm(target.pitch_mm) for view in views], 3),
            seen_px=_stack([view.points.centre_px for view in views], 2),
            sigma_px=_stack([view.points.sigma_px for view in views], 2),
        )
        stripes = [_EMPTY if view.stripe is None else view.stripe for view in views]
        stripe = StripeTable(
            view=_index([len(part) for part in stripes]),
            seen_px=_stack([part.centre_px for part in stripes], 2),
            normal=_stack([part.normal for part in stripes], 2),
            sigma_px=np.concatenate([np.empty(0), *(part.sigma_px for part in stripes)]),
            along_px=np.concatenate([np.empty(0), *(_along(part) for part in stripes)]),
        )
        return cls(len(views), dots, stripe, _radius_mm(views, target))


_EMPTY = StripePoints(
    centre_px=np.empty((0, 2)),
    normal=np.empty((0, 2)),
    sigma_px=np.empty(0),
    width_px=np.empty(0),
    peak=np.empty(0),
    saturated=np.empty(0, dtype=bool),
    cause=(),
)


def _radius_mm(views: Sequence[View], target: Target) -> float:
    """Return the radius of the dots: as given, else as most pictures show it, else 0."""
    if target.kind != "dots":
        return 0.0
    if target.diameter_mm is not None:
        return target.diameter_mm / 2.0
    seen = [view.dot_radius for view in views if view.dot_radius is not None]
    return float(np.median(seen)) * target.pitch_mm if seen else 0.0


def _index(lengths: Sequence[int]) -> IntArray:
    return np.repeat(np.arange(len(lengths)), lengths)


def _along(stripe: StripePoints) -> FloatArray:
    """Return places along the main direction of the points, shape (N,)."""
    if len(stripe) < 2:
        return np.zeros(len(stripe))
    centred = stripe.centre_px - stripe.centre_px.mean(axis=0)
    return np.asarray(centred @ np.linalg.svd(centred, full_matrices=False)[2][0])


def _stack(parts: Sequence[FloatArray], width: int) -> FloatArray:
    return np.concatenate([np.empty((0, width)), *parts])
