"""Where the solve of a rig begins: poses of cameras, boards, targets; numberings; false showings.

From the anchor and the board that it sees most, cameras and boards are joined one after the
other, each by the showings that two cameras took part in.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.errors import CalibError, Degenerate, TooFewViews
from calib.rigid import RigidTransform
from calib.solving.rig.hand_eye import (
    FEWEST_SHOWINGS,
    Agreement,
    Numbered,
    agree_on_boards,
    agree_on_both,
    agree_on_cameras,
    judge,
    turns_between,
)
from calib.solving.rig.seen import SeenView
from calib.solving.rig.turned import board_from_middle, board_from_turned, numberings
from calib.target import Target

# Turns smaller than this, or than so many times what noise makes of none, are none.
_LEAST_TURN_RAD = 0.01
_TURN_OVER_NOISE = 5.0
# Where more than this part of the showings contradict, none is to be believed.
_MOST_CONTRADICTING = 0.5

Channel = tuple[str, str]
"""A sensor and the board that it sees."""


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


@dataclass(frozen=True, slots=True)
class _Link:
    """Two channels, with the showings in which both took part: indices into the views."""

    first: Channel
    second: Channel
    pairs: tuple[tuple[int, int], ...]


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
        self._views, self._targets = views, boards
        self._settled: dict[int, int] = {}
        self._cameras = {anchor: RigidTransform.identity()}  # cam_from_rig
        self._boards = {first: RigidTransform.identity()}  # target from the middle of a board
        self._links = _links(views)

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

    def _joins(self, link: _Link) -> bool:
        """Tell whether a link leads from what is joined to what is not."""
        known = link.first[0] in self._cameras
        board = link.first[1] in self._boards or link.second[1] in self._boards
        return known and board and self._unknowns(link) > 0

    def _unknowns(self, link: _Link) -> int:
        boards = {link.first[1], link.second[1]}
        return (link.second[0] not in self._cameras) + len(boards - self._boards.keys())

    def _cost(self, link: _Link) -> tuple[int, int]:
        return self._unknowns(link), -len(link.pairs)

    def _join_by_first(self, links: Sequence[_Link]) -> None:
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

    def _join(self, link: _Link) -> None:
        (one, one_board), (other, other_board) = link.first, link.second
        first, second = self._numbered(link)
        boards = self._between_boards(link)
        if boards is not None:
            agreement = _unrivalled(agree_on_cameras(first, second, boards), link)
        elif other in self._cameras:
            agreement = agree_on_boards(first, second, self._between_cameras(link))
        else:
            _require_turns(link, first, self._views)
            found = agree_on_both(first, second)
            agreement = _required(found, link)
            kept = np.flatnonzero(agreement.agreeing).astype(np.int64)
            _require_turns(link, _only(first, kept, agreement.numbering[kept, 0]), self._views)
        if other not in self._cameras:
            self._cameras[other] = agreement.cameras @ self._cameras[one]
        if other_board not in self._boards:
            self._boards[other_board] = self._boards[one_board] @ agreement.boards.inverse()
        elif one_board not in self._boards:
            self._boards[one_board] = self._boards[other_board] @ agreement.boards
        self._settle(link, agreement)

    def _between_boards(self, link: _Link) -> RigidTransform | None:
        """Return the second board from the first, None where one is not joined."""
        one, other = link.first[1], link.second[1]
        if one == other:
            return RigidTransform.identity()
        if one not in self._boards or other not in self._boards:
            return None
        return self._boards[other].inverse() @ self._boards[one]

    def _between_cameras(self, link: _Link) -> RigidTransform:
        return self._cameras[link.second[0]] @ self._cameras[link.first[0]].inverse()

    def _numbered(self, link: _Link) -> tuple[Numbered, Numbered]:
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

    def _settle(self, link: _Link, agreement: Agreement) -> None:
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


def _links(views: Sequence[SeenView]) -> list[_Link]:
    """Return all pairs of channels of different sensors, both ways round."""
    pairs: dict[tuple[Channel, Channel], list[tuple[int, int]]] = {}
    for one, other in combinations(range(len(views)), 2):
        if views[one].showing == views[other].showing:
            a, b = ((views[row].sensor, views[row].board) for row in (one, other))
            pairs.setdefault((a, b), []).append((one, other))
            pairs.setdefault((b, a), []).append((other, one))
    return [_Link(a, b, tuple(rows)) for (a, b), rows in sorted(pairs.items())]


def _only(poses: Numbered, rows: IntArray, numbering: IntArray) -> Numbered:
    return Numbered(
        poses.rotation[rows, numbering][:, None],
        poses.place_mm[rows, numbering][:, None],
        np.ones((len(rows), 1), dtype=bool),
    )


def _unrivalled(found: Agreement, link: _Link) -> Agreement:
    """Refuse showings that agree as well on cameras that stand otherwise."""
    if not found.rivalled:
        return found
    raise Degenerate(
        f"{len(link.pairs)} showings to {_names(link)} leave open from which corner each camera "
        "numbered its board, and so how they stand; show the target tilted otherwise as well"
    )


def _required(found: Agreement | None, link: _Link) -> Agreement:
    if found is not None and found.agreeing.sum() >= FEWEST_SHOWINGS:
        return _unrivalled(found, link)
    raise Degenerate(
        f"no {FEWEST_SHOWINGS} of {len(link.pairs)} showings of {_names(link)} agree on how the "
        "cameras stand; keep the target still while all cameras take their picture, and check "
        "that both boards are fixed to each other"
    )


def _names(link: _Link) -> str:
    return f"{link.first[0]!r} and {link.second[0]!r}"


def _require_turns(link: _Link, first: Numbered, views: Sequence[SeenView]) -> None:
    """Refuse showings between which a target of two boards was not turned about two axes.

    Its boards' mutual pose is not known: only what turns moves the one camera's board otherwise
    than the other's. Of a target that is only shifted, the shift between the cameras is open along
    all axes; of one turned about one axis alone, along this.
    """
    count = len(first.rotation)
    if count < FEWEST_SHOWINGS:
        raise TooFewViews(
            f"{count} showings to {_names(link)} together, of two boards; at least "
            f"{FEWEST_SHOWINGS} are needed, the target turned otherwise in each"
        )
    turns = turns_between(first)
    _, values, axes = np.linalg.svd(turns, full_matrices=False)
    spread = values / np.sqrt(len(turns))
    noise = float(np.median([views[row].sigma_rad for row, _ in link.pairs]))
    least = max(_LEAST_TURN_RAD, _TURN_OVER_NOISE * noise)
    if not spread[0] > least:
        raise Degenerate(
            f"the target was shifted but not turned between the showings to {_names(link)} "
            f"({np.degrees(spread[0]):.2g} degrees): the shift between the two cameras is open "
            "along every axis; turn the target by 20 degrees and more, about two axes"
        )
    if not spread[1] > least:
        raise Degenerate(
            f"between the showings to {_names(link)} the target was turned about one axis alone, "
            f"{axis_text(axes[0])} in the frame of camera {link.first[0]!r}: the shift between the "
            "two cameras along this axis is open; turn the target about another axis as well, by "
            "20 degrees and more"
        )


def axis_text(axis: FloatArray) -> str:
    """Return a direction in words: its components, the largest one positive."""
    axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
    return f"({axis[0]:.2f}, {axis[1]:.2f}, {axis[2]:.2f})"


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
