"""The paper's objective functions of the stripe: e4 and e5 (Eqs. 16 and 17)."""

import numpy as np

from calib.arrays import FloatArray
from calib.solving.deviation.back_projection import BackProjection
from calib.solving.deviation.state import Frame, State
from calib.solving.deviation.terms import Block, Distances
from calib.solving.joint.parameters import PLANE_SIZE, POSE_SIZE, tangent_basis


def stripe_terms(frame: Frame, state: State, blunt_mm: float) -> list[Distances]:
    """Return e4 and e5.

    Parameters
    ----------
    frame, state
        The points and where they are held to be.
    blunt_mm
        Distances below this count by their square.
    """
    stripe = frame.observations.stripe
    corrected = stripe.seen_px - state.stripe_px
    back = BackProjection.of(corrected, stripe.view, frame.camera, state.estimate)
    return [_off_board(frame, state, back, blunt_mm), _off_line(frame, state, back, blunt_mm)]


def lines_on_boards(frame: Frame, state: State) -> FloatArray:
    """Return intercept, mm, and slope of the line through each view's stripe points, (M, 2)."""
    stripe = frame.observations.stripe
    corrected = stripe.seen_px - state.stripe_px
    place = BackProjection.of(corrected, stripe.view, frame.camera, state.estimate).place_mm
    lines = np.zeros((frame.observations.count, 2))
    for view in np.unique(stripe.view):
        own = place[stripe.view == view]
        along, across = own.T if frame.along_rows[view] else own.T[::-1]
        slope, intercept = np.polyfit(along, across, 1)
        lines[view] = intercept, slope
    return lines


def _off_board(frame: Frame, state: State, back: BackProjection, blunt_mm: float) -> Distances:
    r"""Return the distances of stripe points from their boards, the points on the sheet (e4).

    The ray :math:`\rho` meets the sheet :math:`n \cdot p + d = 0` at
    :math:`X = -d \rho / (n \cdot \rho)`; its distance from the board with the normal m through t
    is :math:`m \cdot (X - t)`.
    """
    stripe, estimate = frame.observations.stripe, state.estimate
    board = estimate.rotation[stripe.view, :, 2]
    along, facing = back.rays @ estimate.normal, np.einsum("ni,ni->n", board, back.rays)
    arm = -estimate.offset_mm * back.rays / along[:, None] - estimate.translation_mm[stripe.view]
    by_ray = -(estimate.offset_mm / along)[:, None] * (
        board - (facing / along)[:, None] * estimate.normal
    )
    by_pixel = (by_ray[:, None, :] @ back.ray_by_pixel)[:, 0]
    by_pose = np.empty((len(stripe), 1, POSE_SIZE))
    by_pose[:, 0, :3], by_pose[:, 0, 3:] = np.cross(board, arm), -board
    by_plane = np.empty((len(stripe), 1, PLANE_SIZE))
    turned = back.rays @ tangent_basis(estimate.normal)
    by_plane[:, 0, :2] = (estimate.offset_mm * facing / along**2)[:, None] * turned
    by_plane[:, 0, 2] = -facing / along
    blocks = (
        Block(frame.stripe_columns, -by_pixel[:, None, :]),
        Block(frame.pose_columns[stripe.view], by_pose),
        Block(np.broadcast_to(frame.plane_columns, (len(stripe), PLANE_SIZE)), by_plane),
    )
    return Distances(np.einsum("ni,ni->n", board, arm)[:, None], blocks, blunt_mm)


def _off_line(frame: Frame, state: State, back: BackProjection, blunt_mm: float) -> Distances:
    """Return how far stripe points lie, along their column, from the crossing of column and line.

    The points are on the board here. Where the stripe runs along the columns, rows take their
    part (e5).
    """
    stripe = frame.observations.stripe
    index, across = np.arange(len(stripe)), frame.along_rows[stripe.view].astype(np.int64)
    intercept, slope = state.lines[stripe.view].T
    along_mm = back.place_mm[index, 1 - across]

    def off(values: FloatArray) -> FloatArray:
        return np.asarray(values[index, across] - slope[:, None] * values[index, 1 - across])

    by_line = np.column_stack([-np.ones(len(stripe)), -along_mm])
    blocks = (
        Block(frame.stripe_columns, -off(back.by_pixel)[:, None, :]),
        Block(frame.pose_columns[stripe.view], off(back.by_pose)[:, None, :]),
        Block(frame.line_columns[stripe.view], by_line[:, None, :]),
    )
    return Distances(off(back.place_mm[:, :, None]) - intercept[:, None], blocks, blunt_mm)
