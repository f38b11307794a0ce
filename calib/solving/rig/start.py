"""Where the solve of a rig begins: poses of cameras, boards, targets; numberings; false showings.

From the anchor and the board that it sees most, cameras and boards are joined one after the
other, each by the showings that two cameras took part in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from calib.errors import TooFewViews
from calib.rigid import RigidTransform
from calib.solving.rig.contradicting import contradiction, require_agreement
from calib.solving.rig.joining import Joining
from calib.solving.rig.links import require_shared
from calib.solving.rig.numbered_views import NumberedViews
from calib.solving.rig.seen import SeenView
from calib.solving.rig.turned import board_from_middle
from calib.target import Target


@dataclass(frozen=True, slots=True, eq=False)
class RigStart:
    """A first state.

    Attributes
    ----------
    rig_from_camera, target_from_board, rig_from_target
        By name of sensor, board and showing.
    views
        Those of the showings that agree, their numbering settled.
    left_out
        Why showings are left out, by name.
    """

    rig_from_camera: Mapping[str, RigidTransform]
    target_from_board: Mapping[str, RigidTransform]
    rig_from_target: Mapping[str, RigidTransform]
    views: tuple[SeenView, ...]
    left_out: Mapping[str, str]

    def without(self, doubted: Mapping[str, str]) -> "RigStart":
        """Return the start without some showings, left out for these reasons."""
        return replace(
            self,
            views=tuple(view for view in self.views if view.showing not in doubted),
            left_out={**self.left_out, **doubted},
        )


def start_rig(views: Sequence[SeenView], boards: Mapping[str, Target], anchor: str) -> RigStart:
    """Find where cameras, boards and targets stand, and in which numbering each board was seen.

    Raises
    ------
    TooFewViews
        If the anchor saw nothing, or two cameras share fewer showings than their poses take.
    Degenerate
        If a camera shares no showing with others, the target was not turned about two axes, or
        most showings contradict each other.
    """
    seen_by_anchor = [view.board for view in views if view.sensor == anchor]
    if not seen_by_anchor:
        raise TooFewViews(f"sensor {anchor!r} has no usable picture of a board; show it the target")
    first = max(sorted(set(seen_by_anchor)), key=seen_by_anchor.count)
    seen = NumberedViews(views, boards)
    joining = Joining(seen, anchor, first)
    joining.join_all()
    misses_mm = _contradicting(seen, joining)
    require_agreement(len(misses_mm), len({view.showing for view in views}))
    kept = [row for row, view in enumerate(views) if view.showing not in misses_mm]
    require_shared([views[row] for row in kept], list(joining.cam_from_rig), anchor)
    return RigStart(
        rig_from_camera={name: each.inverse() for name, each in joining.cam_from_rig.items()},
        target_from_board={
            name: each @ board_from_middle(boards[name]).inverse()
            for name, each in joining.target_from_middle.items()
        },
        # Of several views of a showing the first says where the target was.
        rig_from_target={
            views[row].showing: _rig_from_target(seen, joining, row) for row in reversed(kept)
        },
        views=tuple(replace(views[row], quarters=seen.quarters(row)) for row in kept),
        left_out={name: contradiction(miss) for name, miss in misses_mm.items()},
    )


def _contradicting(seen: NumberedViews, joining: Joining) -> dict[str, float]:
    """Return by how many mm showings contradict the others, and settle how all are numbered."""
    misses_mm: dict[str, float] = {}
    for link in joining.links:
        if link.first > link.second:
            continue  # the same pairs, the other way round
        found = joining.judged(link)
        seen.settle(link, found)
        for (row, _), miss_mm, agrees in zip(
            link.pairs, found.miss_mm, found.agreeing, strict=True
        ):
            if not agrees:
                misses_mm[seen.views[row].showing] = float(miss_mm)
    return misses_mm


def _rig_from_target(seen: NumberedViews, joining: Joining, row: int) -> RigidTransform:
    view = seen.views[row]
    cam_from_target = seen.cam_from_middle(row) @ joining.target_from_middle[view.board].inverse()
    return joining.cam_from_rig[view.sensor].inverse() @ cam_from_target
