"""The door of the rig's solve: from showings of a rigid target to sensors in one frame."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from calib.calibration import SolvedView, Termination
from calib.errors import TooFewViews
from calib.sensor import LaserSensor
from calib.solving.prepared import rms_px
from calib.solving.rig.answer import RigCalibration, SolvedRigView
from calib.solving.rig.assembly import (
    all_points,
    fits_of,
    solved_boards,
    solved_pictures,
    solved_rig,
)
from calib.solving.rig.bent import without_bent_sheets
from calib.solving.rig.contradicting import require_agreement
from calib.solving.rig.doubts import Doubts, doubts_of
from calib.solving.rig.links import require_shared
from calib.solving.rig.problem import Given, RigProblem, first_state
from calib.solving.rig.reach import reach_of, reach_warnings
from calib.solving.rig.seen import SeenView, seen_views
from calib.solving.rig.showing import RigShowing, check_names
from calib.solving.rig.solve import RigSolution, solve_rig
from calib.solving.rig.start import RigStart, start_rig
from calib.solving.rig.warnings import (
    board_warnings,
    calibration_warnings,
    doubt_warnings,
    fit_warnings,
)
from calib.target import Target


def calibrate_rig(
    showings: Sequence[RigShowing],
    sensors: Mapping[str, LaserSensor],
    boards: Mapping[str, Target],
    *,
    anchor: str,
    sigma_board_mm: float | Mapping[str, float] = 0.01,
) -> RigCalibration:
    r"""Calibrate how the sensors of a rig stand, from showings of a rigid target.

    Parameters
    ----------
    showings
        The target, shown several times; at each, every camera sees one of its boards or none. A
        showing that one camera alone saw still serves its sensor and the boards.
    sensors
        As calibrated, each by itself; their covariances are priors, and what has no variance is
        held. Their order is that of the rig. A sheet that its stripes are far off was bent since:
        it is solved from these pictures alone, and told.
    boards
        The target's boards by name. Their mutual pose is not known, but the same in all showings;
        one board that all cameras see is the simplest target.
    anchor
        The sensor whose camera carries the frame.
    sigma_board_mm
        How far a dot is printed off its nominal place, along each axis, independently: one
        standard deviation, of all boards or by board.

    Returns
    -------
    RigCalibration
        Showings and pictures that cannot be used are left out and named.

    Raises
    ------
    ValueError
        If a showing names a sensor or board that is not there.
    TooFewViews
        If a sensor has no usable picture, or two share fewer than three showings of two boards.
    Degenerate
        If the showings leave open how two cameras stand: they share none; a target of two boards
        was only shifted, or turned about one axis alone; the numberings of boards cannot be told
        apart; most showings contradict each other; or the points of a sensor are known in the rig
        to no better than a millimetre.
    NotConverged
        If the solve does not end.

    Notes
    -----
    Most likely together are: the poses of the target, of its boards on it, and of the cameras; all
    cameras and light planes with their priors; and the places of the dots on the boards, with
    theirs. Each kind of point of each sensor has its own scatter and share of outliers.

    With two boards of unknown mutual pose, a target that is only shifted tells the turn between
    the cameras, and nothing of the shift between them; turned about one axis alone, it tells all
    but the shift along this axis. Neither stripes nor intrinsics mend this: they tell of each
    camera by itself. One board seen by both cameras would tell all in a single showing, were it
    not for its numbering.

    A grid looks the same after half a turn. All numberings of all pictures are tried, and those
    are taken in which the showings agree: of one board two, tilted otherwise, are enough. With one
    board alone, a showing is numbered as the first of the two cameras saw it.
    """
    check_names(showings, sensors, boards, anchor)
    sigma = _sigma_by_board(sigma_board_mm, boards)
    views, reasons = seen_views(showings, sensors, boards)
    _require_pictures(views, sensors, reasons)
    opened, bent = without_bent_sheets(views, sensors)
    given = Given(opened, boards, sigma, anchor)
    found = _solved(given, start_rig(views, boards, anchor))
    start, problem, solution = found.start, found.problem, found.solution
    rig = solved_rig(problem, solution)
    reach = reach_of(rig, problem)
    seen = {(view.showing, view.sensor): view for view in start.views}
    pictures = solved_pictures(problem, solution, seen)
    fits = fits_of(problem, solution)
    solved = solved_boards(problem, solution, sigma)
    dots, stripe = all_points(problem, solution)
    return RigCalibration(
        rig=rig,
        anchor=anchor,
        boards=solved,
        views=_all_views(showings, pictures, {**_by_view(showings, start.left_out), **reasons}),
        left_out=start.left_out,
        fits=fits,
        reach=reach,
        rms_dots_px=rms_px(dots),
        rms_stripe_px=rms_px(stripe),
        termination=Termination.CONVERGED,
        iterations=solution.iterations,
        cost=solution.cost,
        warnings=(
            *(f"{name} left out: {why}" for name, why in start.left_out.items()),
            *(f"{showing}, {name}: {why}" for (showing, name), why in reasons.items()),
            *bent,
            *calibration_warnings(problem, solution),
            *doubt_warnings(found.doubts),
            *fit_warnings(fits),
            *board_warnings(solved),
            *reach_warnings(reach),
        ),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """A start, and where the solve from it ended."""

    start: RigStart
    problem: RigProblem
    solution: RigSolution
    doubts: Doubts

    @classmethod
    def of(cls, given: Given, start: RigStart) -> "_Solved":
        problem = given.problem(start.views)
        solution = solve_rig(problem, first_state(problem, start))
        return cls(start, problem, solution, doubts_of(problem, solution))


def _solved(given: Given, start: RigStart) -> _Solved:
    """Solve, and again without showings that then contradict the others.

    Where a showing is no worse than all the others are without it, something else is wrong with
    all of them, and it stays.
    """
    asked = len({view.showing for view in start.views}) + len(start.left_out)
    solved = _Solved.of(given, start)
    while solved.doubts.worst > 1.0:
        start = solved.start.without(solved.doubts.reasons)
        require_agreement(len(start.left_out), asked)
        require_shared(start.views, list(given.sensors), given.anchor)
        without = _Solved.of(given, start)
        if solved.doubts.worst <= without.doubts.usual:
            break
        solved = without
    return solved


def _sigma_by_board(
    sigma_board_mm: float | Mapping[str, float], boards: Mapping[str, Target]
) -> dict[str, float]:
    if isinstance(sigma_board_mm, Mapping):
        sigma = {name: float(sigma_board_mm[name]) for name in boards}
    else:
        sigma = dict.fromkeys(boards, float(sigma_board_mm))
    for name, each in sigma.items():
        if not 0.0 <= each < float("inf"):
            raise ValueError(f"sigma_board_mm of {name!r} must be 0 or more, got {each!r}")
    return sigma


def _require_pictures(
    views: Sequence[SeenView],
    sensors: Mapping[str, LaserSensor],
    reasons: Mapping[tuple[str, str], str],
) -> None:
    for name in sensors:
        if any(view.sensor == name for view in views):
            continue
        own = [why for (_, sensor), why in reasons.items() if sensor == name]
        raise TooFewViews(
            f"sensor {name!r} has no usable picture of a board"
            + (f"; the first one left out: {own[0]}" if own else "")
            + "; show it the target"
        )


def _by_view(
    showings: Sequence[RigShowing], left_out: Mapping[str, str]
) -> dict[tuple[str, str], str]:
    return {
        (showing.name, sensor): left_out[showing.name]
        for showing in showings
        if showing.name in left_out
        for sensor in showing.views
    }


def _all_views(
    showings: Sequence[RigShowing],
    pictures: Mapping[tuple[str, str], SolvedRigView],
    reasons: Mapping[tuple[str, str], str],
) -> tuple[SolvedRigView, ...]:
    """Return every picture given, in their order."""
    return tuple(
        pictures[showing.name, sensor]
        if (showing.name, sensor) in pictures
        else SolvedRigView(
            showing.name,
            sensor,
            board,
            0,
            SolvedView(view.name, None, None, None, left_out=reasons[showing.name, sensor]),
            view,
        )
        for showing in showings
        for sensor, (board, view) in showing.views.items()
    )
