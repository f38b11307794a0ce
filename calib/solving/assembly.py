"""From a method's answer, in flat tables, to the views as they were given."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from calib.calibration import SolvedPoints, SolvedView
from calib.rigid import RigidTransform
from calib.solving.prepared import PointsAnswer
from calib.views import Cause, StripePoints, TargetPoints, View


def solved_views(
    views: Sequence[View],
    usable: Sequence[int],
    reasons: Mapping[int, str],
    poses: Sequence[RigidTransform],
    dots: PointsAnswer,
    stripe: PointsAnswer | None,
    false_stripes: frozenset[int],
) -> tuple[SolvedView, ...]:
    """Return every view given, solved or left out.

    Parameters
    ----------
    views, usable, reasons
        All views; indices of those that took part; why the others did not.
    poses, dots, stripe
        The answer, in the order of `usable`; `stripe` is None where only the camera was asked.
    false_stripes
        Indices of views whose whole stripe was not believed.
    """
    solved = {
        index: SolvedView(view.name, None, None, None, left_out=reasons[index])
        for index, view in enumerate(views)
        if index in reasons
    }
    dot, point = 0, 0
    for index, pose in zip(usable, poses, strict=True):
        view = views[index]
        dot_rows = slice(dot, dot := dot + len(view.points))
        solved_dots = _solved(dots, dot_rows, view.points, Cause.OUTLIER)
        solved_stripe = None
        if stripe is not None and view.stripe is not None:
            rows = slice(point, point := point + len(view.stripe))
            if index in false_stripes:
                # What a point looks like does not matter where its whole stripe is false.
                seen = replace(view.stripe, cause=(Cause.STRAY_LIGHT,) * len(view.stripe))
            else:
                seen = view.stripe
            solved_stripe = _solved(stripe, rows, seen, Cause.OFF_LINE)
        solved[index] = SolvedView(view.name, pose, solved_dots, solved_stripe)
    return tuple(solved[index] for index in range(len(views)))


def misfits(views: Sequence[View], dots: PointsAnswer, least_part: float) -> dict[int, str]:
    """Return why views do not show the target, by place: those most of whose dots do not fit it."""
    edges = np.cumsum([0, *(len(view.points) for view in views)])
    believed = np.add.reduceat(dots.used.astype(np.int64), edges[:-1])
    return {
        place: f"only {believed[place]} of {len(view.points)} target points fit the target"
        for place, view in enumerate(views)
        if believed[place] < least_part * len(view.points)
    }


def _solved(
    answer: PointsAnswer, rows: slice, points: TargetPoints | StripePoints, blame: Cause
) -> SolvedPoints:
    used = answer.used[rows]
    return SolvedPoints(
        corrected_px=answer.corrected_px[rows],
        used=used,
        cause=tuple(
            seen if taken or seen is not Cause.NONE else blame
            for seen, taken in zip(points.cause, used, strict=True)
        ),
    )
