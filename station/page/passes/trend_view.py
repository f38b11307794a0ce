"""How a quantity of a wheelset changed over its passes, as a chart takes it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import pairwise
from math import isfinite

from measure import Limit, Limits, Quantity, Side
from station.page.formats import quantity as written
from station.page.texts import Texts
from station.store import JsonObject
from station.trains import QuantityTrend, TrendValue, WheelsetTrend

_COLOURS = {Side.LEFT: "--left", Side.RIGHT: "--right"}
_DECIMALS = 4


@dataclass(frozen=True, slots=True)
class Trended:
    """The values of a quantity, of both wheels of a wheelset; its sides are the wheelset's own."""

    quantity: Quantity
    sides: tuple[tuple[Side, QuantityTrend], ...]
    limit: Limit | None

    @classmethod
    def of(cls, trend: WheelsetTrend, quantity: Quantity, limits: Limits) -> "Trended":
        """Take the quantity out of a wheelset's trends."""
        sides = tuple(
            (each.side, each.quantities[quantity])
            for each in trend.sides
            if quantity in each.quantities
        )
        return cls(quantity, sides, limits.of.get(quantity))

    def chart(self, texts: Texts) -> JsonObject:
        """Return what `lineChart` draws: values with u95, limits, bands, and what changed when."""
        moments = sorted({value.at for _, trend in self.sides for value in trend.values})
        return {
            "x": [moment.timestamp() for moment in moments],
            "series": [_series(side, trend, moments, texts) for side, trend in self.sides],
            "levels": list(self._levels(texts)),
            "spans": list(self._spans()),
            "moments": list(self._moments(texts)),
            "rates": list(self._rates(texts)),
        }

    def _levels(self, texts: Texts) -> Iterator[JsonObject]:
        for name, end in (("low", self._low), ("high", self._high)):
            if end is not None:
                text = texts.say(f"passes.trend.limit_{name}", value=written(end, "mm"))
                yield {"value": end, "label": text, "colour": "--bad"}

    def _spans(self) -> Iterator[JsonObject]:
        """Yield what is beyond the limits, and what is near the end that wear leads to."""
        if self._low is not None:
            yield {"from": None, "to": self._low, "colour": "--bad"}
        if self._high is not None:
            yield {"from": self._high, "to": None, "colour": "--bad"}
        worn = self._high if self.quantity.grows_with_wear else self._low
        if self.limit is None or worn is None:
            return
        inwards = -1.0 if self.quantity.grows_with_wear else 1.0
        near = worn + inwards * self.limit.warn_within_mm
        yield {"from": min(near, worn), "to": max(near, worn), "colour": "--warn"}

    def _moments(self, texts: Texts) -> Iterator[JsonObject]:
        for side, trend in self.sides:
            for before, after in pairwise(trend.values):
                if before.calibration_id != after.calibration_id:
                    text = texts.say("passes.trend.calibration", side=_side(side, texts))
                    yield _moment(after, text, _COLOURS[side])
            for value in trend.values:
                if value.jump is not None:
                    text = texts.say("passes.trend.jump", side=_side(side, texts))
                    yield _moment(value, text, "--bad")

    def _rates(self, texts: Texts) -> Iterator[str]:
        for side, trend in self.sides:
            if trend.per_pass is not None:
                yield texts.say(
                    "passes.trend.rate",
                    side=_side(side, texts),
                    rate=written(trend.per_pass.value_mm, "mm", 3),
                    u95=written(trend.per_pass.u95_mm, "mm", 3),
                    count=trend.fitted,
                )

    @property
    def _low(self) -> float | None:
        return self.limit.low_mm if self.limit and isfinite(self.limit.low_mm) else None

    @property
    def _high(self) -> float | None:
        return self.limit.high_mm if self.limit and isfinite(self.limit.high_mm) else None


def _series(
    side: Side, trend: QuantityTrend, moments: Sequence[datetime], texts: Texts
) -> JsonObject:
    values = {value.at: value for value in trend.values}
    found = [values.get(moment) for moment in moments]
    return {
        "label": texts.say(f"passes.side.{side}"),
        "colour": _COLOURS[side],
        "points": True,
        "values": [each and round(each.value, _DECIMALS) for each in found],
        "u95": [each and round(each.u95, _DECIMALS) for each in found],
        "measurements": [each and each.measurement_id for each in found],
    }


def _moment(value: TrendValue, label: str, colour: str) -> JsonObject:
    return {"x": value.at.timestamp(), "label": label, "colour": colour}


def _side(side: Side, texts: Texts) -> str:
    return texts.say(f"passes.side.{side}")
