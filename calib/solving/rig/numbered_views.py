"""The poses of boards before cameras, in every numbering that may be; settled one by one."""

from collections.abc import Mapping, Sequence

import numpy as np

from calib.rigid import RigidTransform
from calib.solving.rig.closed_form import Numbered
from calib.solving.rig.hand_eye import Agreement
from calib.solving.rig.links import Link
from calib.solving.rig.seen import SeenView
from calib.solving.rig.turned import board_from_middle, board_from_turned, numberings
from calib.target import Target


class NumberedViews:
    """Views whose boards may have been numbered from another corner.

    Poses are those of a board's middle. About it numberings differ by a turn alone: however they
    are all turned, the same showings then miss by the same.
    """

    def __init__(self, views: Sequence[SeenView], boards: Mapping[str, Target]) -> None:
        self.views = tuple(views)
        self._boards = boards
        self._settled: dict[int, int] = {}

    def quarters(self, row: int) -> int:
        """Return by how many quarter turns a view is numbered off; 0 where nothing settled it."""
        return self._settled.get(row, 0)

    def cam_from_middle(self, row: int) -> RigidTransform:
        """Return the pose of a view's board in that numbering."""
        return self._cam_from_middle(row, self.quarters(row))

    def of_link(self, link: Link) -> tuple[Numbered, Numbered]:
        """Return what both cameras of a link saw, in the numberings that are still allowed.

        Of one board that both see nothing tells from which corner it is numbered: the first
        camera's numbering is taken.
        """
        same = link.first[1] == link.second[1]
        return (
            self._numbered([one for one, _ in link.pairs], first_only=same),
            self._numbered([other for _, other in link.pairs], first_only=False),
        )

    def settle(self, link: Link, agreement: Agreement) -> None:
        """Keep the numberings in which showings of a link agree; what was settled before stays."""
        for place in np.flatnonzero(agreement.agreeing):
            for row, choice in zip(link.pairs[place], agreement.numbering[place], strict=True):
                self._settled.setdefault(row, self._numberings(row)[choice])

    def _numberings(self, row: int) -> tuple[int, ...]:
        return numberings(self._boards[self.views[row].board])

    def _numbered(self, rows: Sequence[int], *, first_only: bool) -> Numbered:
        """Return poses in all numberings; what is settled, or told to be the first, is allowed."""
        quarters = self._numberings(rows[0])
        maps = [[self._cam_from_middle(row, each) for each in quarters] for row in rows]
        allowed = [
            [
                each == self._settled[row] if row in self._settled else not (first_only and each)
                for each in quarters
            ]
            for row in rows
        ]
        return Numbered(
            np.array([[each.rotation for each in row] for row in maps]),
            np.array([[each.translation_mm for each in row] for row in maps]),
            np.array(allowed),
        )

    def _cam_from_middle(self, row: int, quarters: int) -> RigidTransform:
        view = self.views[row]
        board = self._boards[view.board]
        turned = board_from_turned(board, quarters)
        return view.cam_from_board @ turned.inverse() @ board_from_middle(board)
