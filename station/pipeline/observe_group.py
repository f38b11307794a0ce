"""One pose in several exposures: each dot from where it is seen best, the stripe from where it is.

Dots and stripe want different light: what shows the dots well burns the stripe out, and what shows
the stripe leaves the dots in the dark.  With the laser off the dots are whole where the stripe
crosses them, and what differs with the laser on is the stripe and nothing else.
"""

from collections.abc import Iterable, Sequence
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


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """One picture of the pose."""

    name: str
    picture: Picture
    exposure: Exposure


def observe_group(shots: Sequence[Shot], target: Target) -> View:
    """Return what the shots of one pose show together, under the name of the stripe's.

    Raises
    ------
    CalibError
        If the target is found in none of them.
    """
    seen = _seen([shot for shot in shots if not shot.exposure.laser], target)
    with_laser = [shot for shot in shots if shot.exposure.laser]
    # Without the laser no dot is crossed; with it, dots are looked for where that is all there is.
    dots = seen or _seen(with_laser, target)
    if not dots:
        return observe_target(shots[0].picture, target, name=shots[0].name)
    best_shot, best_view = max(dots, key=lambda pair: _information(pair[1].points))
    stripes = [_stripe_of(shot, shots, best_shot, target) for shot in with_laser]
    found = [view for view in stripes if view is not None and view.stripe is not None]
    points = best_points([view.points for _, view in dots])
    if not found:
        name = with_laser[0].name if with_laser else best_shot.name
        return View(name, points, None, (), best_view.dot_radius)
    likeliest = max(found, key=_unclipped_points)
    return View(likeliest.name, points, likeliest.stripe, likeliest.rivals, best_view.dot_radius)


def best_points(seen: Iterable[TargetPoints]) -> TargetPoints:
    """Return each point from the picture that shows it best.

    A point that nothing speaks against goes before a doubtful one, then the smaller sigma decides.
    """
    best: dict[tuple[int, int], tuple[tuple[bool, float], TargetPoints, int]] = {}
    for points in seen:
        size = np.hypot(points.sigma_px[:, 0], points.sigma_px[:, 1])
        for i, place in enumerate(zip(points.row.tolist(), points.col.tolist(), strict=True)):
            rank = (points.cause[i] is not Cause.NONE, float(size[i]))
            if place not in best or rank < best[place][0]:
                best[place] = (rank, points, i)
    chosen = [(points, i) for _, (_, points, i) in sorted(best.items())]
    return TargetPoints(
        row=np.array([points.row[i] for points, i in chosen]),
        col=np.array([points.col[i] for points, i in chosen]),
        centre_px=np.array([points.centre_px[i] for points, i in chosen]),
        sigma_px=np.array([points.sigma_px[i] for points, i in chosen]),
        cause=tuple(points.cause[i] for points, i in chosen),
    )


def _seen(shots: Sequence[Shot], target: Target) -> list[tuple[Shot, View]]:
    found = []
    for shot in shots:
        # A picture that differs from itself by nothing shows no stripe: a line of glare in a
        # picture taken with the laser off is not to be taken for one.
        dark = None if shot.exposure.laser else shot.picture
        try:
            view = observe_target(shot.picture, target, name=shot.name, laser_off=dark)
            found.append((shot, view))
        except CalibError:  # too dark or too bright for the dots: another shot of the pose is not
            continue
    return found


def _stripe_of(shot: Shot, shots: Sequence[Shot], dots: Shot, target: Target) -> View | None:
    dark = next((one for one in shots if shot.exposure.differs_by_laser(one.exposure)), None)
    try:
        if dark is None:
            return observe_target(shot.picture, target, name=shot.name)
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
