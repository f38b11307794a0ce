"""Cameras and boards of a rig joined one after the other, by showings two cameras took part in."""

from collections.abc import Sequence

import numpy as np

from calib.arrays import IntArray
from calib.errors import CalibError, Degenerate, TooFewViews
from calib.rigid import RigidTransform
from calib.solving.rig.closed_form import FEWEST_SHOWINGS, Numbered
from calib.solving.rig.hand_eye import (
    Agreement,
    agree_on_boards,
    agree_on_both,
    agree_on_cameras,
    judge,
)
from calib.solving.rig.links import Link, links_of, names_of
from calib.solving.rig.numbered_views import NumberedViews
from calib.solving.rig.turn_axes import require_turns


class Joining:
    """Cameras and boards that are joined already; grows until all are.

    Parameters
    ----------
    seen
        All views; which numbering each is in is settled as they are joined.
    anchor
        The sensor whose camera carries the frame.
    first
        The board that is the target's frame, taken about its middle.
    """

    def __init__(self, seen: NumberedViews, anchor: str, first: str) -> None:
        self.links = links_of(seen.views)
        self.cam_from_rig = {anchor: RigidTransform.identity()}
        self.target_from_middle = {first: RigidTransform.identity()}  # of each board
        self._seen = seen

    def join_all(self) -> None:
        """Join every sensor and board that was seen.

        Raises
        ------
        TooFewViews
            If two cameras share fewer showings than their poses take.
        Degenerate
            If one shares no showing with the others, or showings leave open how they stand.
        """
        while missing := self._missing():
            links = sorted(filter(self._joins, self.links), key=self._cost)
            if not links:
                raise Degenerate(
                    f"{missing} shares no showing with {self._names()}; show the target so that "
                    "both see one of its boards at the same time"
                )
            self._join_by_first(links)

    def judged(self, link: Link) -> Agreement:
        """Tell which showings of a link agree with where all stand, once all are joined."""
        first, second = self._seen.of_link(link)
        return judge(first, second, self._between_cameras(link), self._between_boards(link))

    def _missing(self) -> str:
        for view in self._seen.views:
            if view.sensor not in self.cam_from_rig:
                return f"sensor {view.sensor!r}"
            if view.board not in self.target_from_middle:
                return f"board {view.board!r}"
        return ""

    def _names(self) -> str:
        return ", ".join(repr(name) for name in self.cam_from_rig)

    def _joins(self, link: Link) -> bool:
        """Tell whether a link leads from what is joined to what is not."""
        boards = {link.first[1], link.second[1]}
        known = link.first[0] in self.cam_from_rig and boards & self.target_from_middle.keys()
        return bool(known) and self._unknowns(link) > 0

    def _unknowns(self, link: Link) -> int:
        boards = {link.first[1], link.second[1]}
        return (link.second[0] not in self.cam_from_rig) + len(
            boards - self.target_from_middle.keys()
        )

    def _cost(self, link: Link) -> tuple[int, int]:
        return self._unknowns(link), -len(link.pairs)

    def _join_by_first(self, links: Sequence[Link]) -> None:
        """Join by the first link that can; the refusal of the first is told where none can."""
        refusals: list[CalibError] = []
        for link in links:
            try:
                self._join(link)
            except (Degenerate, TooFewViews) as refusal:
                refusals.append(refusal)
            else:
                return
        raise refusals[0]

    def _join(self, link: Link) -> None:
        agreement = self._agreement(link)
        (one, one_board), (other, other_board) = link.first, link.second
        if other not in self.cam_from_rig:
            self.cam_from_rig[other] = agreement.cameras @ self.cam_from_rig[one]
        boards = self.target_from_middle
        if other_board not in boards:
            boards[other_board] = boards[one_board] @ agreement.boards.inverse()
        elif one_board not in boards:
            boards[one_board] = boards[other_board] @ agreement.boards
        self._seen.settle(link, agreement)

    def _agreement(self, link: Link) -> Agreement:
        """Find what is not joined of a link, with what is held."""
        first, second = self._seen.of_link(link)
        if self._boards_stand(link):
            found = agree_on_cameras(first, second, self._between_boards(link))
            return _unrivalled(found, link)
        if link.second[0] in self.cam_from_rig:
            return agree_on_boards(first, second, self._between_cameras(link))
        require_turns(link, first, self._seen.views)
        agreement = _required(agree_on_both(first, second), link)
        kept = np.flatnonzero(agreement.agreeing).astype(np.int64)
        require_turns(link, _only(first, kept, agreement.numbering[kept, 0]), self._seen.views)
        return agreement

    def _boards_stand(self, link: Link) -> bool:
        """Tell whether it is known how the two boards stand to each other; one does to itself."""
        one, other = link.first[1], link.second[1]
        return one == other or {one, other} <= self.target_from_middle.keys()

    def _between_boards(self, link: Link) -> RigidTransform:
        """Return the second board from the first, where both stand."""
        one, other = link.first[1], link.second[1]
        if one == other:
            return RigidTransform.identity()
        return self.target_from_middle[other].inverse() @ self.target_from_middle[one]

    def _between_cameras(self, link: Link) -> RigidTransform:
        return self.cam_from_rig[link.second[0]] @ self.cam_from_rig[link.first[0]].inverse()


def _only(poses: Numbered, rows: IntArray, numbering: IntArray) -> Numbered:
    return Numbered(
        poses.rotation[rows, numbering][:, None],
        poses.place_mm[rows, numbering][:, None],
        np.ones((len(rows), 1), dtype=bool),
    )


def _unrivalled(found: Agreement, link: Link) -> Agreement:
    """Refuse showings that agree as well on cameras that stand otherwise."""
    if not found.rivalled:
        return found
    raise Degenerate(
        f"{len(link.pairs)} showings to {names_of(link)} leave open from which corner each camera "
        "numbered its board, and so how they stand; show the target tilted otherwise as well"
    )


def _required(found: Agreement | None, link: Link) -> Agreement:
    if found is not None and found.agreeing.sum() >= FEWEST_SHOWINGS:
        return _unrivalled(found, link)
    raise Degenerate(
        f"no {FEWEST_SHOWINGS} of {len(link.pairs)} showings of {names_of(link)} agree on how the "
        "cameras stand; keep the target still while all cameras take their picture, and check "
        "that both boards are fixed to each other"
    )
