"""The paper's objective functions of the dots: e1, e2 and e3 (Eqs. 13 to 15)."""

from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.solving.deviation.back_projection import BackProjection
from calib.solving.deviation.cross_ratios import cross_ratio
from calib.solving.deviation.state import Frame, State
from calib.solving.deviation.terms import Block, Distances
from calib.solving.joint.discs import cross_matrices


@dataclass(frozen=True, slots=True)
class Blunt:
    """Below which lengths the distances of each kind count by their square."""

    on_picture_px: float
    on_board_mm: float
    of_ratio: float

    def times(self, part: float) -> "Blunt":
        """Return the same lengths, all larger or smaller."""
        return Blunt(part * self.on_picture_px, part * self.on_board_mm, part * self.of_ratio)


def dot_terms(frame: Frame, state: State, fours: IntArray, blunt: Blunt) -> list[Distances]:
    """Return e1 and e2, each of the dots and of their picture's centre, and e3."""
    dots = frame.observations.dots
    corrected = dots.seen_px - state.dots_px
    back = BackProjection.of(corrected, dots.view, frame.camera, state.estimate)
    first = _forward(frame, state, corrected, blunt)
    second = _backward(frame, back, blunt)
    terms = [first, _centres(first, frame), second, _centres(second, frame)]
    return [*terms, _ratios(frame, back, fours, blunt)] if len(fours) else terms


def _forward(frame: Frame, state: State, corrected_px: FloatArray, blunt: Blunt) -> Distances:
    """Return the corrected dots less the projected ones (e1)."""
    dots = frame.observations.dots
    rotation = state.estimate.rotation[dots.view]
    arm = (rotation @ dots.board_mm[:, :, None])[:, :, 0]
    points = arm + state.estimate.translation_mm[dots.view]
    projected, by_point, _ = frame.camera.project_with_jacobians(points)
    by_pose = np.concatenate([by_point @ cross_matrices(arm), -by_point], axis=2)
    by_deviation = np.broadcast_to(-np.eye(2), (len(dots), 2, 2))
    blocks = (
        Block(frame.dot_columns, by_deviation),
        Block(frame.pose_columns[dots.view], by_pose),
    )
    return Distances(corrected_px - projected, blocks, blunt.on_picture_px)


def _backward(frame: Frame, back: BackProjection, blunt: Blunt) -> Distances:
    """Return the dots carried back to the target less their places on it (e2)."""
    dots = frame.observations.dots
    blocks = (
        Block(frame.dot_columns, -back.by_pixel),
        Block(frame.pose_columns[dots.view], back.by_pose),
    )
    return Distances(back.place_mm - dots.board_mm[:, :2], blocks, blunt.on_board_mm)


def _centres(term: Distances, frame: Frame) -> Distances:
    """Return the sums of a term's differences, one a picture: its statistical centre."""
    view, count = frame.observations.dots.view, frame.observations.count
    edges = np.searchsorted(view, np.arange(count + 1))
    most = int(np.diff(edges).max())
    # Views of fewer dots repeat a dot with a derivative of zero.
    own = edges[:-1, None] + np.arange(most)
    there = own < edges[1:, None]
    own = np.where(there, own, edges[:-1, None])
    by_dot, by_pose = term.blocks
    values = np.where(there[:, :, None, None], by_dot.values[own], 0.0)
    return Distances(
        np.add.reduceat(term.difference, edges[:-1], axis=0),
        (
            Block(
                by_dot.columns[own].reshape(count, -1),
                values.transpose(0, 2, 1, 3).reshape(count, 2, -1),
            ),
            Block(frame.pose_columns, np.add.reduceat(by_pose.values, edges[:-1], axis=0)),
        ),
        term.blunt,
        wide=True,
    )


def _ratios(frame: Frame, back: BackProjection, fours: IntArray, blunt: Blunt) -> Distances:
    """Return the cross-ratios in the pictures less those on the target (e3)."""
    on_board, _ = cross_ratio(frame.observations.dots.board_mm[fours, :2])
    seen, by_ray = cross_ratio(back.rays[fours, :2])
    by_deviation = -by_ray[:, :, None, :] @ back.ray_by_pixel[fours, :2]
    block = Block(
        frame.dot_columns[fours].reshape(len(fours), -1),
        by_deviation.reshape(len(fours), 1, -1),
    )
    return Distances((seen - on_board)[:, None], (block,), blunt.of_ratio)
