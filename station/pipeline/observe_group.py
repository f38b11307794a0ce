"""One pose in several exposures: each dot from where it is seen well, the stripe from where it is.

Dots and stripe want different light: what shows the dots well burns the stripe out, and what shows
the stripe leaves the dots in the dark.  With the laser off the dots are whole where the stripe
crosses them, and what differs with the laser on is the stripe and nothing else.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    CalibError,
    Cause,
    Picture,
    Target,
    TargetPoints,
    View,
    observe_target,
)
from station.pipeline.exposures import Exposure
from station.pipeline.merge_points import merge_points


@dataclass(frozen=True, slots=True, eq=False)
class PoseShot:
    """One picture of the pose."""

    name: str
    picture: Picture
    exposure: Exposure


def observe_group(shots: Sequence[PoseShot], target: Target) -> View:
    """Return what the shots of one pose show together, under the name of the stripe's.

    Raises
    ------
    CalibError
        If the target is found in none of them.
    """
    seen = {shot.name: view for shot in shots if (view := _seen(shot, target)) is not None}
    if not seen:
        return observe_target(shots[0].picture, target, name=shots[0].name)
    with_laser = [shot for shot in shots if shot.exposure.laser]
    # Without the laser no dot is crossed: there the board is found the most surely.
    clear = [shot for shot in shots if shot.name in seen and not shot.exposure.laser]
    dots = max(
        clear or [shot for shot in with_laser if shot.name in seen],
        key=lambda shot: _information(seen[shot.name].points),
    )
    stripes = [_stripe_of(shot, shots, dots, seen.get(shot.name), target) for shot in with_laser]
    found = [view for view in stripes if view is not None and view.stripe is not None]
    points = merge_points([view.points for view in seen.values()])
    dot_radius = seen[dots.name].dot_radius
    if not found:
        name = with_laser[0].name if with_laser else dots.name
        return View(name, points, None, (), dot_radius)
    likeliest = max(found, key=_unclipped_points)
    return View(likeliest.name, points, likeliest.stripe, likeliest.rivals, dot_radius)


def _seen(shot: PoseShot, target: Target) -> View | None:
    # A picture that differs from itself by nothing shows no stripe: a line of glare in a picture
    # taken with the laser off is not to be taken for one.
    dark = None if shot.exposure.laser else shot.picture
    try:
        return observe_target(shot.picture, target, name=shot.name, laser_off=dark)
    except CalibError:  # too dark or too bright for the dots: another shot of the pose is not
        return None


def _stripe_of(
    shot: PoseShot, shots: Sequence[PoseShot], dots: PoseShot, alone: View | None, target: Target
) -> View | None:
    """Return the shot with its stripe: less its laser-off partner, else as seen `alone`."""
    dark = next((one for one in shots if shot.exposure.differs_by_laser(one.exposure)), None)
    if dark is None:
        return alone
    try:
        return observe_target(
            shot.picture,
            target,
            name=shot.name,
            laser_off=dark.picture,
            points_in=dots.picture,
        )
    except CalibError:
        return None


def _information(points: TargetPoints) -> float:
    """Return what the points tell: the sum of 1 / variance of those nothing speaks against."""
    good = np.array([cause is Cause.NONE for cause in points.cause])
    return float((1.0 / (points.sigma_px[good] ** 2).sum(axis=1)).sum())


def _unclipped_points(view: View) -> int:
    """Return how many points of the stripe the sensor did not clip.

    Not what their sigmas promise: speckle makes most of a point's error, it is the same in every
    exposure, and the greatest promise would be the one most underrated.
    """
    return 0 if view.stripe is None else int((~view.stripe.saturated).sum())
