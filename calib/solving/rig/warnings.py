"""What the reader of a rig's calibration should know, in one line each."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import chdtri

from calib.solving.rig.answer import SensorFit, SolvedBoard
from calib.solving.rig.doubts import Doubts
from calib.solving.rig.problem import RigProblem
from calib.solving.rig.solve import RigSolution

# A scatter this many times the predicted one is worth telling.
_SCALE_WORTH_TELLING = 2.0
# A true calibration is contradicted so often.
_CALIBRATION_CHANCE = 1e-6
# As are showings that contradict each other so many times, in squares, what the scatter makes.
_DOUBT_WORTH_TELLING = 4.0
# As is a board whose points are so many times farther off than told.
_BOARD_WORTH_TELLING = 1.5


def calibration_warnings(problem: RigProblem, solution: RigSolution) -> tuple[str, ...]:
    """Tell of sensors that are no longer as their own calibrations found them.

    Their own parameters are counted in prior standard deviations, so the sum of their squares is
    a chi square of no more than as many degrees of freedom.
    """
    return tuple(
        f"the pictures contradict the calibration of {name!r}, by "
        f"{np.sqrt(own @ own / len(own)):.2g} of its standard deviations; calibrate it anew"
        for name, own in zip(problem.sensors, solution.place.state.own, strict=True)
        if len(own) and own @ own > chdtri(len(own), _CALIBRATION_CHANCE)
    )


def doubt_warnings(doubts: Doubts) -> tuple[str, ...]:
    """Tell of showings that contradict each other all alike."""
    if doubts.usual <= _DOUBT_WORTH_TELLING:
        return ()
    return (
        f"the showings contradict each other {np.sqrt(doubts.usual):.2g} times as much as their "
        "points' scatter allows; check that the boards are flat, of the size told, and fixed to "
        "each other",
    )


def fit_warnings(fits: Mapping[str, SensorFit]) -> tuple[str, ...]:
    """Tell where points scatter otherwise than predicted, and of sheets that were not seen."""
    scales = [
        (name, kind, scale)
        for name, fit in fits.items()
        for kind, scale in (
            ("target points", fit.sigma_scale_dots),
            ("stripe points", fit.sigma_scale_stripe),
        )
    ]
    return tuple(
        f"the {kind} of {name!r} scatter {scale:.2g} times as much as predicted; the covariance "
        "accounts for it"
        for name, kind, scale in scales
        if scale > _SCALE_WORTH_TELLING
    ) + tuple(
        f"no stripe of {name!r} was seen or believed: its sheet is as its own calibration left it"
        for name, fit in fits.items()
        if fit.rms_stripe_px == 0.0
    )


def board_warnings(boards: Sequence[SolvedBoard]) -> tuple[str, ...]:
    """Tell of boards whose points are farther off their places than was told."""
    return tuple(
        f"the points of board {board.name!r} lie {board.found_sigma_mm:.2g} mm off their places "
        f"where {board.sigma_mm:.2g} mm was told; say what it is, or measure the board"
        for board in boards
        if board.found_sigma_mm > _BOARD_WORTH_TELLING * max(board.sigma_mm, 1e-3)
    )
