"""The usable pictures of all showings as one list, each with its pose by its own dots."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.solving.prepared import solve_dots
from calib.solving.rig.showing import RigShowing
from calib.solving.rival_stripes import exchanged
from calib.solving.start import (
    LEAST_STRIPE_POINTS,
    StripeLine,
    has_stripe,
    stripe_line,
    usable_views,
)
from calib.target import Target
from calib.views import View

# A view of whose points fewer than this part is believed does not show the board.
LEAST_BELIEVED = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class SeenView:
    """One picture of one showing.

    Attributes
    ----------
    showing, sensor, board
        Whose picture, and of which board.
    view
        What was seen; its stripe is, of several lines, the one nearest to the known sheet.
    cam_from_board
        By its own dots, numbered as they came.
    line
        That of its stripe in space, None without one.
    sigma_mm, sigma_rad
        How well that pose is known: its place and its turn, along the worst axis.
    quarters
        By how many quarter turns its numbering is off that of the board.
    """

    showing: str
    sensor: str
    board: str
    view: View
    cam_from_board: RigidTransform
    line: StripeLine | None
    sigma_mm: float
    sigma_rad: float
    quarters: int = 0


def seen_views(
    showings: Sequence[RigShowing],
    sensors: Mapping[str, LaserSensor],
    boards: Mapping[str, Target],
) -> tuple[list[SeenView], dict[tuple[str, str], str]]:
    """Return the usable pictures with their poses, and why others are not, by showing and sensor.

    Every camera's pictures of every board are solved by themselves, the camera held.
    """
    seen: list[SeenView] = []
    reasons: dict[tuple[str, str], str] = {}
    for name, sensor in sensors.items():
        for board, target in boards.items():
            found = [
                (showing.name, showing.views[name][1])
                for showing in showings
                if name in showing.views and showing.views[name][0] == board
            ]
            usable, unusable = usable_views([view for _, view in found], target, sensor.camera)
            reasons |= {(found[index][0], name): why for index, why in unusable.items()}
            if not usable:
                continue
            posed, failed = _posed([found[index] for index in usable], name, sensor, board, target)
            seen += posed
            reasons |= failed
    order = {showing.name: index for index, showing in enumerate(showings)}
    return sorted(seen, key=lambda each: order[each.showing]), reasons


def _posed(
    found: Sequence[tuple[str, View]], name: str, sensor: LaserSensor, board: str, target: Target
) -> tuple[list[SeenView], dict[tuple[str, str], str]]:
    solution = solve_dots([view for _, view in found], target, sensor.camera)
    believed = solution.dots_mixture.believed(solution.dots.residual)
    edges = np.cumsum([0, *(len(view.points) for _, view in found)])
    seen, failed = [], {}
    for index, (showing, view) in enumerate(found):
        count = int(believed[edges[index] : edges[index + 1]].sum())
        if count < LEAST_BELIEVED * len(view.points):
            failed[showing, name] = f"only {count} of {len(view.points)} target points fit {board}"
            continue
        pose, covariance = solution.estimate.poses[index], solution.covariance.views[index]
        chosen = _with_nearest_stripe(view, sensor, pose)
        seen.append(
            SeenView(
                showing=showing,
                sensor=name,
                board=board,
                view=chosen,
                cam_from_board=pose,
                line=_line(chosen, sensor, pose),
                sigma_mm=float(np.sqrt(np.linalg.eigvalsh(covariance[3:, 3:])[-1])),
                sigma_rad=float(np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1])),
            )
        )
    return seen, failed


def _line(view: View, sensor: LaserSensor, pose: RigidTransform) -> StripeLine | None:
    if view.stripe is None or not has_stripe(view):
        return None
    return stripe_line(view.stripe, sensor.camera, pose)


def _with_nearest_stripe(view: View, sensor: LaserSensor, pose: RigidTransform) -> View:
    """Return a view whose stripe is, of several lines on the board, the nearest to the sheet."""
    if not view.rivals or not has_stripe(view):
        return view
    lines = [part for part in (view.stripe, *view.rivals) if part is not None]
    misses_mm = [
        np.abs(sensor.plane.distance_mm(stripe_line(part, sensor.camera, pose).ends_mm)).max()
        if len(part) >= LEAST_STRIPE_POINTS
        else np.inf
        for part in lines
    ]
    nearest = int(np.argmin(misses_mm))
    return exchanged(view, nearest) if nearest else view
