"""points.csv: a row a point, as observed, as corrected, and why it was used or not."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from calib import (
    Calibration,
    Cause,
    RigCalibration,
    SolvedPoints,
    SolvedView,
    StripePoints,
    Target,
    TargetPoints,
    View,
)
from station.documents.points_rows import DOT_RADIUS, NEEDED, PointRow, point_rows
from station.errors import InputUnusable

POINT_COLUMNS = (*NEEDED, "u_corrected", "v_corrected", "used", "reason", DOT_RADIUS)


def points_csv(calibration: Calibration) -> str:
    """Return the text of points.csv of a calibration."""
    return _text_of(zip(calibration.seen, calibration.views, strict=True))


def rig_points_csv(calibration: RigCalibration) -> dict[str, str]:
    """Return the text of a points.csv of each sensor of a rig, by its name."""
    names = [each.name for each in calibration.rig.sensors]
    return {
        name: _text_of(
            (each.seen, each.solved) for each in calibration.views if each.sensor == name
        )
        for name in names
    }


def _text_of(pictures: Iterable[tuple[View, SolvedView]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(POINT_COLUMNS)
    for view, answer in pictures:
        writer.writerows(_dot_rows(view, answer))
        if view.stripe is not None:
            writer.writerows(_stripe_rows(view.name, view.stripe, answer))
    return text.getvalue()


def _dot_rows(view: View, answer: SolvedView) -> Iterator[list[object]]:
    points = view.points
    radius = "" if view.dot_radius is None else f"{view.dot_radius:.6f}"
    for i, outcome in enumerate(_outcomes(answer.dots, len(points), answer.left_out)):
        place = [view.name, "dot", points.row[i], points.col[i]]
        yield [*place, *_numbers(points.centre_px[i], points.sigma_px[i]), *outcome, radius]


def _stripe_rows(name: str, stripe: StripePoints, answer: SolvedView) -> Iterator[list[object]]:
    # Across the stripe alone something is known: its sigma, split on u and v by the normal (Eq. 9).
    sigma_px = np.abs(stripe.normal) * stripe.sigma_px[:, None]
    for i, outcome in enumerate(_outcomes(answer.stripe, len(stripe), answer.left_out)):
        yield [name, "stripe", "", "", *_numbers(stripe.centre_px[i], sigma_px[i]), *outcome, ""]


def _outcomes(solved: SolvedPoints | None, count: int, left_out: str) -> Iterator[list[object]]:
    """Yield correction, use and reason; a view left out has a reason in place of numbers."""
    if solved is None:
        yield from [["", "", 0, left_out]] * count
        return
    for corrected_px, used, cause in zip(
        solved.corrected_px, solved.used, solved.cause, strict=True
    ):
        yield [*_numbers(corrected_px), int(used), cause.value]


def _numbers(*pairs: np.ndarray) -> list[str]:
    return [f"{value:.6f}" for pair in pairs for value in pair]


def views_from_points(text: str, target: Target, *, name: str) -> list[View]:
    """Read points.csv, or a file of another detector with its first eight columns, as views.

    Parameters
    ----------
    text
        The file; columns image, kind, row, col, u, v, sigma_u, sigma_v are needed.
        dot_radius_pitches, that of the dots as seen, is read where it stands, others are ignored.
    target
        The target that row and col lie on.
    name
        Name of the file, for messages.

    Raises
    ------
    InputUnusable
        If a row cannot be used (see `point_rows`), a dot is named twice or a stripe point stands
        twice. Stripes of too few points to be a line are the solver's to leave out.
    """
    by_image: dict[str, list[PointRow]] = {}
    for row in point_rows(text, target, name=name):
        by_image.setdefault(row.image, []).append(row)
    if not by_image:
        raise InputUnusable(f"{name}: no points in it; give a row a point")
    return [_view(image, rows, name) for image, rows in by_image.items()]


def _view(image: str, rows: Sequence[PointRow], name: str) -> View:
    dots = [row for row in rows if row.kind == "dot"]
    stripe = [row for row in rows if row.kind == "stripe"]
    _refuse_repeats(((f"dot {r.row}, {r.col}", r) for r in dots), image, name)
    # Counted twice, a point would promise more than it knows.
    _refuse_repeats(((f"the stripe point {r.u}, {r.v}", r) for r in stripe), image, name)
    points = TargetPoints(
        row=np.array([r.row for r in dots], dtype=np.int64),
        col=np.array([r.col for r in dots], dtype=np.int64),
        centre_px=np.array([(r.u, r.v) for r in dots]).reshape(-1, 2),
        sigma_px=np.array([(r.sigma_u, r.sigma_v) for r in dots]).reshape(-1, 2),
        cause=(Cause.NONE,) * len(dots),
    )
    seen_radii = [r.dot_radius for r in dots if r.dot_radius is not None]
    return View(
        image,
        points,
        _stripe(stripe) if stripe else None,
        dot_radius=float(np.median(seen_radii)) if seen_radii else None,
    )


def _refuse_repeats(places: Iterable[tuple[str, PointRow]], image: str, name: str) -> None:
    seen: dict[str, int] = {}
    for place, row in places:
        first = seen.setdefault(place, row.line)
        if first != row.line:
            raise InputUnusable(
                f"{name} line {row.line}: {place} of {image} stands in line {first} already; "
                "leave one out"
            )


def _stripe(rows: Sequence[PointRow]) -> StripePoints:
    centre_px = np.array([(r.u, r.v) for r in rows])
    along = np.linalg.svd(centre_px - centre_px.mean(axis=0), full_matrices=False)[2][0]
    normal = np.array([-along[1], along[0]])
    parts_px = np.array([(r.sigma_u, r.sigma_v) for r in rows])
    count = len(rows)
    return StripePoints(
        centre_px=centre_px,
        normal=np.tile(normal, (count, 1)),
        sigma_px=np.linalg.norm(parts_px, axis=1),
        width_px=np.ones(count),
        peak=np.ones(count),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
