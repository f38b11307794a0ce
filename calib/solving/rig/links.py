"""Which sensors share showings: pairs of what two cameras saw at the same time."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from calib.errors import Degenerate
from calib.solving.rig.seen import SeenView

Channel = tuple[str, str]
"""A sensor and the board that it sees."""


@dataclass(frozen=True, slots=True)
class Link:
    """Two channels, with the showings in which both took part: indices into the views."""

    first: Channel
    second: Channel
    pairs: tuple[tuple[int, int], ...]


def links_of(views: Sequence[SeenView]) -> list[Link]:
    """Return all pairs of channels of different sensors, both ways round."""
    pairs: dict[tuple[Channel, Channel], list[tuple[int, int]]] = {}
    for one, other in combinations(range(len(views)), 2):
        if views[one].showing == views[other].showing:
            a, b = ((views[row].sensor, views[row].board) for row in (one, other))
            pairs.setdefault((a, b), []).append((one, other))
            pairs.setdefault((b, a), []).append((other, one))
    return [Link(a, b, tuple(rows)) for (a, b), rows in sorted(pairs.items())]


def names_of(link: Link) -> str:
    """Return the two sensors' names, quoted."""
    return f"{link.first[0]!r} and {link.second[0]!r}"


def require_shared(views: Sequence[SeenView], sensors: Sequence[str], anchor: str) -> None:
    """Refuse showings that leave a sensor by itself.

    Raises
    ------
    Degenerate
        If a sensor shares no showing with the anchor, nor with one that does.
    """
    joined, links = {anchor}, links_of(views)
    for _ in sensors:
        joined |= {link.second[0] for link in links if link.first[0] in joined}
    for name in sensors:
        if name not in joined:
            raise Degenerate(
                f"sensor {name!r} shares no showing that can be used with "
                f"{', '.join(map(repr, sorted(joined)))}; show the target so that both see one of "
                "its boards at the same time"
            )
