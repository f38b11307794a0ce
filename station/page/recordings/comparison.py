"""Two readings of the same pictures side by side: how far they differ, and whether they agree."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from measure import Alarm, Quantity, Status
from station.store import JsonObject, Measurement

_GRID_STEP_MM = 0.25
_WIDEST_GAP_MM = 2.0
"""Between points that are farther apart the profile was not seen, and nothing is drawn."""
_COVERAGE = 1.96
_STEEPEST = 4.0
"""Up the flange back a height says nothing: a hundredth of a millimetre aside is far up or down."""
_SAME_TIME = timedelta(milliseconds=25)
"""A frame apart at 40 a second; the next wheel of a bogie comes 45 ms later at 40 m/s."""


@dataclass(frozen=True, slots=True)
class Value:
    """What one reading says of a quantity, mm."""

    value: float | None
    u95: float | None
    status: Status
    alarm: Alarm


@dataclass(frozen=True, slots=True)
class Difference:
    """A quantity by two readings, mm."""

    quantity: Quantity
    before: Value
    after: Value

    @property
    def by(self) -> float | None:
        """How much larger the later reading is; None where one of them has no value."""
        if self.before.value is None or self.after.value is None:
            return None
        return self.after.value - self.before.value

    @property
    def u95(self) -> float | None:
        """Uncertainty of the difference, 95 %, were the two independent.

        They are not: their common pictures make it smaller, so it is an upper bound.
        """
        if self.before.u95 is None or self.after.u95 is None:
            return None
        return math.hypot(self.before.u95, self.after.u95)

    @property
    def agrees(self) -> bool | None:
        """Whether they differ by no more than that; None where that cannot be told."""
        if self.by is None or self.u95 is None:
            return None
        return abs(self.by) <= self.u95


@dataclass(frozen=True, slots=True)
class Compared:
    """A wheel by two readings; one of them may be missing."""

    before: Measurement | None
    after: Measurement | None

    @property
    def shown(self) -> Measurement:
        """The reading that names the wheel."""
        found = self.after or self.before
        if found is None:
            raise ValueError("a comparison of nothing")
        return found

    @property
    def differences(self) -> tuple[Difference, ...]:
        """The quantities that one of the readings has a value of."""
        rows = (
            Difference(each, _value(self.before, each), _value(self.after, each))
            for each in Quantity
        )
        return tuple(
            row for row in rows if row.before.value is not None or row.after.value is not None
        )


def compared(before: Iterable[Measurement], after: Iterable[Measurement]) -> tuple[Compared, ...]:
    """Return the wheels of two measurings of one recording, in the order of their frames.

    Readings are of one wheel where they share a frame: with another calibration another of the
    wheel's frames may have carried most weight.  Those of a rig may be kept with the frames of its
    other sensor, which saw the wheel at the same time.
    """
    left = list(before)
    pairs: list[Compared] = []
    for row in after:
        same = next((each for each in left if _of_one_wheel(each, row)), None)
        if same is not None:
            left.remove(same)
        pairs.append(Compared(same, row))
    pairs += [Compared(row, None) for row in left]
    return tuple(sorted(pairs, key=lambda pair: pair.shown.frame))


def profiles_compared(before: JsonObject | None, after: JsonObject | None) -> dict[str, Any] | None:
    """Return two profiles on one grid of places, mm, and their difference; None without a point.

    Parameters
    ----------
    before, after
        Profiles as a measurement keeps them; None where there is none.

    Returns
    -------
    document
        `d_mm`, and with null where a profile was not seen: `before_mm`, `after_mm`,
        `difference_um` (after minus before; null, too, where the profile is upright), `u95_um` of
        it, were the two independent.
    """
    given = [each for each in (before, after) if each is not None and len(each["d_mm"]) > 1]
    if not given:
        return None
    places = [d for each in given for d in (min(each["d_mm"]), max(each["d_mm"]))]
    d_mm = np.arange(math.ceil(min(places)), max(places), _GRID_STEP_MM)
    if len(d_mm) < 2:
        return None
    h = [_at(each, "h_mm", d_mm) for each in (before, after)]
    steep = np.maximum(*(np.abs(np.gradient(each, _GRID_STEP_MM)) for each in h)) > _STEEPEST
    difference_mm = np.where(steep, np.nan, h[1] - h[0])
    sigma = [_at(each, "sigma_mm", d_mm) for each in (before, after)]
    return {
        "d_mm": d_mm.tolist(),
        "before_mm": _told(h[0]),
        "after_mm": _told(h[1]),
        "difference_um": _told(1000.0 * difference_mm),
        "u95_um": _told(1000.0 * _COVERAGE * np.hypot(*sigma)),
    }


def _value(row: Measurement | None, quantity: Quantity) -> Value:
    told = {} if row is None else row.wheel.get(quantity) or {}
    return Value(
        value=told.get("value"),
        u95=told.get("u95"),
        status=Status(told.get("status", Status.MISSING)),
        alarm=Alarm(told.get("alarm", Alarm.UNKNOWN)),
    )


def _of_one_wheel(one: Measurement, other: Measurement) -> bool:
    if one.recording_id == other.recording_id:
        return bool(_frames(one) & _frames(other))
    times = [
        datetime.fromisoformat(time) for each in (one, other) if (time := each.wheel.get("time"))
    ]
    return len(times) == 2 and abs(times[0] - times[1]) <= _SAME_TIME


def _frames(row: Measurement) -> set[int]:
    return {row.frame, *row.wheel.get("frames", ())}


def _at(profile: JsonObject | None, what: str, d_mm: Any) -> Any:
    """Return a column of a profile at other places, NaN where no point is near."""
    if profile is None or len(profile["d_mm"]) < 2:
        return np.full(len(d_mm), np.nan)
    own = np.array(profile["d_mm"])
    order = np.argsort(own, kind="stable")
    own, values = own[order], np.array(profile[what])[order]
    right = np.clip(np.searchsorted(own, d_mm), 1, len(own) - 1)
    seen = (own[0] <= d_mm) & (d_mm <= own[-1]) & (own[right] - own[right - 1] <= _WIDEST_GAP_MM)
    return np.where(seen, np.interp(d_mm, own, values), np.nan)


def _told(values: Any) -> Sequence[float | None]:
    return [None if math.isnan(each) else round(each, 4) for each in values.tolist()]
