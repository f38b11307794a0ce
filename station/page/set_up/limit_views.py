"""The limits in force, each as a band along its own scale."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

from measure import Limit, Limits, Quantity
from station.settings import LimitsSettings

BACK_TO_BACK: Final = "back_to_back"
_MARGIN: Final = 0.25
"""What is drawn beyond an end, as a part of the range."""
_OPEN_RANGE_MM: Final = 6.0
"""What is drawn of a range without an end."""

Kind = Literal["good", "warn", "bad"]


@dataclass(frozen=True, slots=True)
class Stretch:
    """A part of a band: from a hundredth of its length, so many hundredths long."""

    kind: Kind
    start: float
    length: float


@dataclass(frozen=True, slots=True)
class LimitView:
    """The limit of one quantity; None of an end that there is not.

    Attributes
    ----------
    warns_from_mm
        The value at which the warning starts, at the worn end; None where there is none.
    from_file
        Whether the settings file gives it, and not the preset.
    """

    name: str
    low_mm: float | None
    high_mm: float | None
    warns_from_mm: float | None
    jump_mm: float | None
    from_file: bool
    band: Sequence[Stretch]


def limit_views(limits: Limits, settings: LimitsSettings) -> list[LimitView]:
    """Return the limits in the order of the quantities, the back-to-back distance last."""
    found = [
        _view(quantity.value, limits.of[quantity], quantity.value in settings.given, quantity)
        for quantity in Quantity
        if quantity in limits.of
    ]
    if limits.back_to_back is not None:
        given = settings.back_to_back is not None
        found.append(_view(BACK_TO_BACK, limits.back_to_back, given, None))
    return found


def _view(name: str, limit: Limit, from_file: bool, quantity: Quantity | None) -> LimitView:
    low, high = _finite(limit.low_mm), _finite(limit.high_mm)
    worn_high = quantity is not None and quantity.grows_with_wear
    warns_from = None if quantity is None else _warns_from(limit, worn_high=worn_high)
    return LimitView(
        name=name,
        low_mm=low,
        high_mm=high,
        warns_from_mm=warns_from,
        jump_mm=None if quantity is None else _finite(limit.jump_mm),
        from_file=from_file,
        band=tuple(_band(limit, warns_from, worn_high=worn_high)),
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _warns_from(limit: Limit, *, worn_high: bool) -> float | None:
    inward = -limit.warn_within_mm if worn_high else limit.warn_within_mm
    start = (limit.high_mm if worn_high else limit.low_mm) + inward
    # A margin that is wider than the range warns of all of it.
    return _finite(min(max(start, limit.low_mm), limit.high_mm))


def _band(limit: Limit, warns_from: float | None, *, worn_high: bool) -> Iterator[Stretch]:
    """Yield the stretches of a band from its least value to its greatest."""
    ends = [end for end in (limit.low_mm, limit.high_mm) if math.isfinite(end)]
    if not ends:
        return
    inner = max(ends) - min(ends) or _OPEN_RANGE_MM
    start = min(ends) - (_MARGIN if math.isfinite(limit.low_mm) else 1.0) * inner
    end = max(ends) + (_MARGIN if math.isfinite(limit.high_mm) else 1.0) * inner
    inside = [] if warns_from is None else [warns_from]
    for first, last in pairwise(sorted({start, *ends, *inside, end})):
        middle, scale = (first + last) / 2.0, 100.0 / (end - start)
        kind = _kind(middle, limit, warns_from, worn_high=worn_high)
        yield Stretch(kind, scale * (first - start), scale * (last - first))


def _kind(value: float, limit: Limit, warns_from: float | None, *, worn_high: bool) -> Kind:
    if not (limit.low_mm <= value <= limit.high_mm):
        return "bad"
    if warns_from is None:
        return "good"
    return "warn" if (value > warns_from) == worn_high else "good"
