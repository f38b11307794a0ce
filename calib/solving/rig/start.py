"""Where the solve of a rig begins: poses of cameras, boards, targets; numberings; false showings.

From the anchor and the board that it sees most, cameras and boards are joined one after the
other, each by the showings that two cameras took part in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

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
from calib.solving.rig.links import Link, links_of, names_of, require_shared
from calib.solving.rig.seen import SeenView
from calib.solving.rig.turn_axes import require_turns
from calib.solving.rig.turned import board_from_middle, board_from_turned, numberings
from calib.target import Target

# Where more than this part of the showings contradict, none is to be believed.
_MOST_CONTRADICTING = 0.5


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
        If a camera shares no showing with others, or the target was not turned about two axes.
    """
    seen_by_anchor = [view.board for view in views if view.sensor == anchor]
    if not seen_by_anchor:
        raise TooFewViews(f"sensor {anchor!r} has no usable picture of a board; show it the target")
    first = max(sorted(set(seen_by_anchor)), key=seen_by_anchor.count)
    joining = _Joining(list(views), boards, anchor, first)
    joining.join_all()
    return joining.settled()


class _Joining:
    """Cameras and boards that are joined already; grows until all are."""

    def __init__(
        self, views: list[SeenView], boards: Mapping[str, Target], anchor: str, first: str
    ) -> None:
        self._views, self._targets, self._anchor = views, boards, anchor
        self._settled: dict[int, int] = {}
        self._cameras = {anchor: RigidTransform.identity()}  # cam_from_rig
        self._boards = {first: RigidTransform.identity()}  # target from the middle of a board
        self._links = links_of(views)

    def join_all(self) -> None:
        """Join every sensor and board that was seen."""
        while missing := self._missing():
            links = sorted(filter(self._joins, self._links), key=self._cost)
            if not links:
                raise Degenerate(
                    f"{missing} shares no showing with {self._names()}; show the target so that "
                    "both see one of its boards at the same time"
                )
            self._join_by_first(links)

    def _missing(self) -> str:
        for view in self._views:
            if view.sensor not in self._cameras:
                return f"sensor {view.sensor!r}"
            if view.board not in self._boards:
                return f"board {view.board!r}"
        return ""

    def _names(self) -> str:
        return ", ".join(repr(name) for name in self._cameras)

    def _joins(self, link: Link) -> bool:
        """Tell whether a link leads from what is joined to what is not."""
        known = link.first[0] in self._cameras
        board = link.first[1] in self._boards or link.second[1] in self._boards
        return known and board and self._unknowns(link) > 0

    def _unknowns(self, link: Link) -> int:
        boards = {link.first[1], link.second[1]}
        return (link.second[0] not in self._cameras) + len(boards - self._boards.keys())

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
        (one, one_board), (other, other_board) = link.first, link.second
        first, second = self._numbered(link)
        boards = self._between_boards(link)
        if boards is not None:
            agreement = _unrivalled(agree_on_cameras(first, second, boards), link)
        elif other in self._cameras:
            agreement = agree_on_boards(first, second, self._between_cameras(link))
        else:
            require_turns(link, first, self._views)
            found = agree_on_both(first, second)
            agreement = _required(found, link)
            kept = np.flatnonzero(agreement.agreeing).astype(np.int64)
            require_turns(link, _only(first, kept, agreement.numbering[kept, 0]), self._views)
        if other not in self._cameras:
            self._cameras[other] = agreement.cameras @ self._cameras[one]
        if other_board not in self._boards:
            self._boards[other_board] = self._boards[one_board] @ agreement.boards.inverse()
        elif one_board not in self._boards:
            self._boards[one_board] = self._boards[other_board] @ agreement.boards
        self._settle(link, agreement)

    def _between_boards(self, link: Link) -> RigidTransform | None:
        """Return the second board from the first, None where one is not joined."""
        one, other = link.first[1], link.second[1]
        if one == other:
            return RigidTransform.identity()
        if one not in self._boards or other not in self._boards:
            return None
        return self._boards[other].inverse() @ self._boards[one]

    def _between_cameras(self, link: Link) -> RigidTransform:
        return self._cameras[link.second[0]] @ self._cameras[link.first[0]].inverse()

    def _numbered(self, link: Link) -> tuple[Numbered, Numbered]:
        same = link.first[1] == link.second[1]
        return (
            self._poses([one for one, _ in link.pairs], first_only=same),
            self._poses([other for _, other in link.pairs], first_only=False),
        )

    def _poses(self, rows: Sequence[int], *, first_only: bool) -> Numbered:
        """Return poses in all numberings; what is settled, or told to be the first, is allowed."""
        quarters = numberings(self._targets[self._views[rows[0]].board])
        maps = [[self._pose(row, each) for each in quarters] for row in rows]
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

    def _pose(self, row: int, quarters: int) -> RigidTransform:
        """Return the pose of a board, taken about its middle, in a numbering.

        About its middle, numberings differ by a turn alone: however they are all turned, the same
        showings then miss by the same.
        """
        view = self._views[row]
        target = self._targets[view.board]
        turned = board_from_turned(target, quarters)
        return view.cam_from_board @ turned.inverse() @ board_from_middle(target)

    def _settle(self, link: Link, agreement: Agreement) -> None:
        for place in np.flatnonzero(agreement.agreeing):
            for row, choice in zip(link.pairs[place], agreement.numbering[place], strict=True):
                quarters = numberings(self._targets[self._views[row].board])
                self._settled.setdefault(row, quarters[choice])

    def settled(self) -> RigStart:
        """Settle what every showing was numbered like, and which of them agree."""
        misses: dict[str, float] = {}
        for link in self._links:
            if link.first > link.second:
                continue  # the same pairs, the other way round
            boards = self._between_boards(link)
            assert boards is not None  # noqa: S101  all boards are joined by now
            found = judge(*self._numbered(link), self._between_cameras(link), boards)
            self._settle(link, found)
            for (row, _), miss, agrees in zip(
                link.pairs, found.miss_mm, found.agreeing, strict=True
            ):
                if not agrees:
                    misses[self._views[row].showing] = float(miss)
        require_agreement(len(misses), len({view.showing for view in self._views}))
        kept = [row for row, view in enumerate(self._views) if view.showing not in misses]
        require_shared([self._views[row] for row in kept], list(self._cameras), self._anchor)
        return RigStart(
            rig_from_camera={name: each.inverse() for name, each in self._cameras.items()},
            target_from_board={
                name: each @ board_from_middle(self._targets[name]).inverse()
                for name, each in self._boards.items()
            },
            rig_from_target={
                self._views[row].showing: self._rig_from_target(row) for row in reversed(kept)
            },
            views=tuple(
                replace(self._views[row], quarters=self._settled.get(row, 0)) for row in kept
            ),
            left_out={name: contradiction(miss) for name, miss in misses.items()},
        )

    def _rig_from_target(self, row: int) -> RigidTransform:
        view = self._views[row]
        cam_from_middle = self._pose(row, self._settled.get(row, 0))
        cam_from_target = cam_from_middle @ self._boards[view.board].inverse()
        return self._cameras[view.sensor].inverse() @ cam_from_target


def contradiction(miss_mm: float) -> str:
    """Return why a showing that contradicts the others by so much is left out."""
    return (
        f"its pictures contradict the other showings by {miss_mm:.2g} mm: the target moved between "
        "them, or they are not of this target"
    )


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


def require_agreement(contradicting: int, showings: int) -> None:
    """Refuse showings most of which contradict each other.

    Raises
    ------
    Degenerate
        If it is more than a half.
    """
    if contradicting > _MOST_CONTRADICTING * showings:
        raise Degenerate(
            f"{contradicting} of {showings} showings contradict the others; keep the target still "
            "while all cameras take their picture, and check that its boards are fixed to each "
            "other"
        )
