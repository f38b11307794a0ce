r"""A state of a rig with the residuals of all pictures, and the normal equations that follow.

Each picture is looked at as if it stood alone (`calib.solving.joint.residuals`): a pose of the
board before the camera, and a sensor. What the unknowns of the rig do to these is the chain

.. math:: \text{cam}_k\text{ from board}_b = (\text{rig from cam}_k)^{-1}\;
          \text{rig from target}_s\; \text{target from board}_b.

The dots' places on the boards, 3 unknowns each and seen in many pictures, are the blocks that
`NormalEquations` eliminates.
"""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import FloatArray
from calib.solving.joint.discs import cross_matrices
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import POSE_SIZE, Estimate
from calib.solving.joint.residuals import Linear, linearise_dots, linearise_stripe
from calib.solving.rig.problem import Channel, RigProblem
from calib.solving.rig.unknowns import FULL_LAYOUT, RigLayout, RigState


@dataclass(frozen=True, slots=True, eq=False)
class ChannelPlace:
    """One channel at a state.

    Attributes
    ----------
    estimate
        Its sensor, and cam_from_board of its M pictures.
    dots, stripe
        Residuals and Jacobians, by the pose of the picture and the whole sensor.
    by_dot
        d(dot)/d(its place on the board) over sigma, shape (N, 2, 3).
    chain
        d(pose of each picture)/d(unknowns), shape (M, 6, P).
    step_by_own
        d(sensor)/d(unknowns), shape (12, P).
    """

    estimate: Estimate
    dots: Linear
    stripe: Linear
    by_dot: FloatArray
    chain: FloatArray
    step_by_own: FloatArray

    @classmethod
    def at(cls, channel: Channel, problem: RigProblem, state: RigState) -> "ChannelPlace":
        prior = problem.priors[channel.sensor]
        own = state.own[channel.sensor]
        estimate = _with_poses(prior.at(own), channel, state)
        table = channel.observations.dots
        shifted = replace(table, board_mm=table.board_mm + state.dot_shift_mm[channel.dot])
        observations = replace(channel.observations, dots=shifted)
        # A wild trial step may divide by zero; its cost is then not finite and it is refused.
        with np.errstate(all="ignore"):
            dots = linearise_dots(observations, estimate, FULL_LAYOUT)
            stripe = linearise_stripe(observations.stripe, estimate, FULL_LAYOUT, channel.rays)
        step_by_own = np.zeros((FULL_LAYOUT.size, problem.layout.size))
        step_by_own[:, problem.layout.own(channel.sensor)] = prior.step_by_own(own)
        return cls(
            estimate=estimate,
            dots=dots,
            stripe=stripe,
            by_dot=dots.jacobian[:, :, 3:POSE_SIZE] @ estimate.rotation[table.view],
            chain=_chain(channel, problem.layout, state),
            step_by_own=step_by_own,
        )

    def dots_equations(self, channel: Channel, weights: FloatArray, dots: int) -> NormalEquations:
        """Return the normal equations of the dots, `dots` of them on all boards."""
        table, count = channel.observations.dots, channel.observations.count
        alone = NormalEquations.of(self.dots, weights, table.view, count)
        weighted = self.by_dot * weights[:, None, None]
        with_sensor = np.einsum("nki,nkj->nij", weighted, self.dots.jacobian[:, :, POSE_SIZE:])
        by_view = self.dots_by_pose(channel, weights, dots)
        by_sensor = _summed(with_sensor, channel, dots)
        border = by_view.reshape(3 * dots, -1) @ self.chain.reshape(count * POSE_SIZE, -1)
        chained = self._chained(alone)
        return replace(
            chained,
            views=_summed(np.einsum("nki,nkj->nij", weighted, self.by_dot), channel, dots),
            border=border.reshape(dots, 3, -1) + by_sensor @ self.step_by_own,
            views_side=_summed(
                np.einsum("nki,nk->ni", weighted, self.dots.residual), channel, dots
            ),
        )

    def dots_by_pose(self, channel: Channel, weights: FloatArray, dots: int) -> FloatArray:
        """Return what couples dots to the pose of each picture, shape (D, 3, M, 6)."""
        count, view = channel.observations.count, channel.observations.dots.view
        weighted = self.by_dot * weights[:, None, None]
        coupled = np.zeros((dots, 3, count, POSE_SIZE))
        coupled[channel.dot, :, view] = np.einsum(
            "nki,nkj->nij", weighted, self.dots.jacobian[:, :, :POSE_SIZE]
        )
        return coupled

    def alone(
        self, channel: Channel, dots_weight: FloatArray, stripe_weight: FloatArray
    ) -> NormalEquations:
        """Return the normal equations of the pictures, as if each stood alone."""
        seen = channel.observations
        return NormalEquations.of(
            self.dots, dots_weight, seen.dots.view, seen.count
        ) + NormalEquations.of(self.stripe, stripe_weight, seen.stripe.view, seen.count)

    def stripe_equations(self, channel: Channel, weights: FloatArray, dots: int) -> NormalEquations:
        """Return the normal equations of the stripe points; they say nothing of the dots."""
        alone = NormalEquations.of(
            self.stripe, weights, channel.observations.stripe.view, channel.observations.count
        )
        chained = self._chained(alone)
        return replace(
            chained,
            views=np.zeros((dots, 3, 3)),
            border=np.zeros((dots, 3, self.chain.shape[2])),
            views_side=np.zeros((dots, 3)),
        )

    def _chained(self, alone: NormalEquations) -> NormalEquations:
        """Return the equations of single pictures in the unknowns of the rig, as shared ones."""
        size = self.chain.shape[2]
        chain, own = self.chain.reshape(-1, size), self.step_by_own
        weighted = (alone.views @ self.chain).reshape(-1, size)
        cross = chain.T @ (alone.border @ own).reshape(-1, size)
        shared = chain.T @ weighted + cross + cross.T + own.T @ alone.shared @ own
        side = chain.T @ alone.views_side.ravel() + own.T @ alone.shared_side
        return replace(alone, shared=shared, shared_side=side)


def prior_equations(problem: RigProblem, state: RigState) -> NormalEquations:
    """Return the equations of what is known beforehand: of the sensors, and of the dots."""
    size = problem.layout.size
    certainty, shared, side = problem.dot_sigma_mm**-2.0, np.zeros(size), np.zeros(size)
    for index, own in enumerate(state.own):
        shared[problem.layout.own(index)] = 1.0
        side[problem.layout.own(index)] = -own
    squares = certainty @ (state.dot_shift_mm**2).sum(axis=1) + side @ side
    return NormalEquations(
        views=certainty[:, None, None] * np.eye(3),
        border=np.zeros((len(certainty), 3, size)),
        shared=np.diag(shared),
        views_side=-certainty[:, None] * state.dot_shift_mm,
        shared_side=side,
        cost=float(squares) / 2.0,
    )


def _summed(parts: FloatArray, channel: Channel, dots: int) -> FloatArray:
    """Sum up what belongs to the same dot of a board."""
    total = np.zeros((dots, *parts.shape[1:]))
    np.add.at(total, channel.dot, parts)
    return total


def _with_poses(sensor: Estimate, channel: Channel, state: RigState) -> Estimate:
    cam_from_rig = state.cameras.rotation[channel.sensor].T
    targets = state.targets.rotation[channel.showing]
    arm = targets @ state.boards.place_mm[channel.board]
    place = arm + state.targets.place_mm[channel.showing]
    return replace(
        sensor,
        rotation=cam_from_rig @ targets @ state.boards.rotation[channel.board],
        translation_mm=(place - state.cameras.place_mm[channel.sensor]) @ cam_from_rig.T,
    )


def _chain(channel: Channel, layout: RigLayout, state: RigState) -> FloatArray:
    r"""Return d(cam_from_board of each picture)/d(unknowns), shape (M, 6, P).

    With the places of the boards x in the rig, the camera's c, and the turn C of cam_from_rig, a
    step (w, s) of the camera gives the picture's pose :math:`(-C w, C((x - c) \times w - s))`; one
    of the target, whose arm to the board is a, :math:`(C w, C(s - a \times w))`.
    """
    count = len(channel.showing)
    chain = np.zeros((count, POSE_SIZE, layout.size))
    cam_from_rig = state.cameras.rotation[channel.sensor].T
    targets = state.targets.rotation[channel.showing]
    arm = targets @ state.boards.place_mm[channel.board]
    place = arm + state.targets.place_mm[channel.showing]
    from_camera = place - state.cameras.place_mm[channel.sensor]
    for view, showing in enumerate(channel.showing):
        target = layout.target(int(showing))
        chain[view, :, target] = _moved(cam_from_rig, -cross_matrices(arm[view : view + 1])[0])
    if (camera := layout.camera(channel.sensor)).stop:
        for view in range(count):
            lever = -cross_matrices(from_camera[view : view + 1])[0]
            chain[view, :, camera] = -_moved(cam_from_rig, lever)
    if (board := layout.board(channel.board)).stop:
        for view in range(count):
            chain[view, :, board] = _moved(cam_from_rig @ targets[view], np.zeros((3, 3)))
    return chain


def _moved(turn: FloatArray, shift_by_turn: FloatArray) -> FloatArray:
    """Return d(pose)/d(step), shape (6, 6), of a step seen in a turned frame with a lever."""
    block = np.zeros((POSE_SIZE, POSE_SIZE))
    block[:3, :3] = block[3:, 3:] = turn
    block[3:, :3] = turn @ shift_by_turn
    return block
