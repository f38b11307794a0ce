"""The unknowns of method `deviation`: a deviation of every point, and what they are held against.

The order of the unknowns is owned here: two numbers a dot, two a stripe point, then per view its
pose (a small rotation from the left, a shift) and the line of its stripe on the board, at last
the light plane (two angles of the normal, the offset).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.camera import CameraModel
from calib.solving.joint.parameters import PLANE_SIZE, POSE_SIZE, Estimate, Layout
from calib.solving.observations import Observations

LINE_SIZE = 2
RIGID = Layout((), plane=True)
"""Of poses and the light plane, the camera held."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """A deviation of every point, and poses, lines and light plane beside them.

    Attributes
    ----------
    dots_px, stripe_px
        Shapes (N, 2) and (S, 2): deviation = observed - corrected, along u and v.
    estimate
        Camera, poses and light plane.
    lines
        Shape (M, 2): intercept, mm, and slope of each view's stripe on its board.
    """

    dots_px: FloatArray
    stripe_px: FloatArray
    estimate: Estimate
    lines: FloatArray


@dataclass(frozen=True, eq=False)
class Frame:
    """What stays the same while the unknowns move.

    Attributes
    ----------
    observations, camera
        The points; stripe points are only those that take part.
    along_rows
        Shape (M,): the stripe runs more along the rows of dots, so its line is ``y = i + s x`` on
        the board; else ``x = i + s y``.
    """

    observations: Observations
    camera: CameraModel
    along_rows: BoolArray

    @cached_property
    def dot_columns(self) -> IntArray:
        """Columns of the deviations of dots, shape (N, 2)."""
        return np.arange(2 * len(self.observations.dots)).reshape(-1, 2)

    @cached_property
    def stripe_columns(self) -> IntArray:
        """Columns of the deviations of stripe points, shape (S, 2)."""
        start = self.dot_columns.size
        return start + np.arange(2 * len(self.observations.stripe)).reshape(-1, 2)

    @cached_property
    def pose_columns(self) -> IntArray:
        """Columns of the poses, shape (M, 6)."""
        start = self.dot_columns.size + self.stripe_columns.size
        return np.asarray(start + np.arange(POSE_SIZE * self.observations.count)).reshape(
            -1, POSE_SIZE
        )

    @cached_property
    def line_columns(self) -> IntArray:
        """Columns of the lines, shape (M, 2)."""
        start = int(self.pose_columns[-1, -1]) + 1
        return start + np.arange(LINE_SIZE * self.observations.count).reshape(-1, LINE_SIZE)

    @cached_property
    def plane_columns(self) -> IntArray:
        """Columns of the light plane, shape (3,)."""
        return int(self.line_columns[-1, -1]) + 1 + np.arange(PLANE_SIZE)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.plane_columns[-1]) + 1

    def masked(self, *columns: IntArray) -> BoolArray:
        """Return a mask, shape (size,), of some columns."""
        mask = np.zeros(self.size, dtype=bool)
        mask[np.concatenate([part.ravel() for part in columns])] = True
        return mask

    def moved(self, state: State, step: FloatArray, bound_px: FloatArray) -> State:
        """Return the state a step away, deviations held within +-bound.

        Parameters
        ----------
        state
            Where the step begins.
        step
            Shape (size,).
        bound_px
            Shape (2 N + 2 S,), of the deviations in the order of the unknowns.
        """
        deviations = np.concatenate([state.dots_px.ravel(), state.stripe_px.ravel()])
        deviations = np.clip(deviations + step[: len(bound_px)], -bound_px, bound_px)
        dots, stripe = np.split(deviations, [self.dot_columns.size])
        return State(
            dots_px=dots.reshape(-1, 2),
            stripe_px=stripe.reshape(-1, 2),
            estimate=RIGID.moved(state.estimate, step[self.plane_columns], step[self.pose_columns]),
            lines=state.lines + step[self.line_columns],
        )

    def started(self, estimate: Estimate) -> State:
        """Return the paper's start: no deviations; lines come with the first step."""
        seen = self.observations
        return State(
            dots_px=np.zeros((len(seen.dots), 2)),
            stripe_px=np.zeros((len(seen.stripe), 2)),
            estimate=estimate,
            lines=np.zeros((seen.count, LINE_SIZE)),
        )
