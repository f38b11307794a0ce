"""The trend of one quantity of a wheel as SVG: each station's values with u95, line, limits."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isfinite

from measure import Limit
from station.fleet.pages.time_axis import moments_along
from station.fleet.standing import QuantityStanding
from station.fleet.trends import DAY_S, FleetQuantity, FleetValue
from station.fleet.wear import Wear
from station.report import Markup, element, minus, ticks

_WIDTH, _HEIGHT = 560.0, 240.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 52.0, 10.0, 16.0, 24.0
_LEAST_MM = 0.2
"""Drawn at least, so that noise does not look like wear."""
_FAR = 1.5
"""A limit is drawn where it is not so many times farther than the values spread."""
_LEAST_REACH_MM = 1.0
_COLOURS = 6
_MARKS = (
    "m-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0-6.4 0",
    "m-2.9-2.9h5.8v5.8h-5.8z",
    "m0-4l4 4-4 4-4-4z",
    "m0-3.8l3.7 6.6h-7.4z",
)
"""Around a point; with the colour, a mark is that of one station in twelve."""


@dataclass(frozen=True, slots=True)
class Field:
    """What the drawing's rectangle stands for: seconds of Unix time across, mm up."""

    x: tuple[float, float]
    y: tuple[float, float]

    @classmethod
    def around(cls, values: Sequence[FleetValue], ends: Sequence[float]) -> "Field":
        """Hold the values with their u95, and those limits that are not far from them."""
        times = [value.at.timestamp() for value in values]
        low = min(value.value - value.u95 for value in values)
        high = max(value.value + value.u95 for value in values)
        reach = max(_FAR * (high - low), _LEAST_REACH_MM)
        near = [end for end in ends if low - reach <= end <= high + reach]
        low, high = min(low, *near, low), max(high, *near, high)
        spare = max(_LEAST_MM - (high - low), 0.08 * (high - low)) / 2.0
        begin, end = min(times), max(times)
        aside = max(0.03 * (end - begin), DAY_S / 4.0)
        return cls((begin - aside, end + aside), (low - spare, high + spare))

    def across(self, at_s: float) -> float:
        """Return where a moment is."""
        part = (at_s - self.x[0]) / (self.x[1] - self.x[0])
        return _LEFT + part * (_WIDTH - _LEFT - _RIGHT)

    def up(self, value_mm: float) -> float:
        """Return where a value is."""
        part = (value_mm - self.y[0]) / (self.y[1] - self.y[0])
        return _HEIGHT - _BOTTOM - part * (_HEIGHT - _TOP - _BOTTOM)

    def holds(self, value_mm: float) -> bool:
        """Tell whether a value is within it."""
        return self.y[0] <= value_mm <= self.y[1]


def trend_chart(
    found: FleetQuantity, standing: QuantityStanding, stations: Sequence[str], name: str
) -> Markup:
    """Draw the values of a quantity; `name` says for those who do not see it what is drawn.

    Parameters
    ----------
    stations
        All of the wheel's, in the order of their colours.
    """
    values = found.values
    ends = _ends(standing.limit)
    field = Field.around(values, [end for _, end in ends])
    return element(
        "svg",
        _grid(field),
        (_limit(field, label, end) for label, end in ends if field.holds(end)),
        element("path", d=_jumps(field, values), class_="jump"),
        element("path", d=_line(field, standing.wear), class_="fit"),
        (_series(field, values, place, each) for place, each in enumerate(stations)),
        viewBox=f"0 0 {_WIDTH:g} {_HEIGHT:g}",
        class_="trend",
        role="img",
        aria_label=name,
    )


def station_mark(place: int) -> Markup:
    """Return the mark of the station at a place of the order, for a legend."""
    mark = element("path", d=f"M8 8{_MARKS[place % len(_MARKS)]}", class_=_colour(place))
    return element("svg", mark, viewBox="0 0 16 16", aria_hidden="true")


def _colour(place: int) -> str:
    return f"marks c{place % _COLOURS}"


def _ends(limit: Limit | None) -> list[tuple[str, float]]:
    if limit is None:
        return []
    ends = (("not over", limit.high_mm), ("not under", limit.low_mm))
    return [(label, end) for label, end in ends if isfinite(end)]


def _grid(field: Field) -> Markup:
    floor, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
    first, last = (datetime.fromtimestamp(at, tz=UTC) for at in field.x)
    moments = moments_along(first, last)
    values = ticks(*field.y).tolist()
    lines = [f"M{field.across(at.timestamp()):.1f} {_TOP:g}V{floor:g}" for at, _ in moments]
    lines += [f"M{_LEFT:g} {field.up(value):.1f}H{right:g}" for value in values]
    outline = f"M{_LEFT:g} {_TOP:g}H{right:g}V{floor:g}H{_LEFT:g}z"
    return element(
        "g",
        element("path", d="".join(lines), class_="grid"),
        (_moment(field, at, text) for at, text in moments),
        (_tick(field, value) for value in values),
        element("text", "mm", x=4.0, y=12.0),
        element("path", d=outline, class_="outline"),
    )


def _moment(field: Field, at: datetime, text: str) -> Markup:
    # A label in the middle of its line would be cut off at either edge.
    x = min(max(field.across(at.timestamp()), _LEFT + 20.0), _WIDTH - 34.0)
    return element("text", text, x=round(x, 1), y=_HEIGHT - 7.0, text_anchor="middle")


def _tick(field: Field, value: float) -> Markup:
    y = round(field.up(value) + 4.0, 1)
    return element("text", minus(f"{value:g}"), x=_LEFT - 6.0, y=y, text_anchor="end")


def _limit(field: Field, label: str, end: float) -> Markup:
    y = field.up(end)
    inwards = 13.0 if y < _HEIGHT / 2.0 else -5.0
    text = f"{label} {end:g} mm"
    return element(
        "g",
        element("path", d=f"M{_LEFT:g} {y:.1f}H{_WIDTH - _RIGHT:g}", class_="limit-line"),
        element("text", text, x=_LEFT + 6.0, y=round(y + inwards, 1), class_="limit"),
    )


def _jumps(field: Field, values: Iterable[FleetValue]) -> str:
    places = (field.across(v.at.timestamp()) for v in values if v.jump_mm is not None)
    return "".join(f"M{place:.1f} {_TOP:g}V{_HEIGHT - _BOTTOM:g}" for place in places)


def _line(field: Field, wear: Wear | None) -> str:
    """Draw the wear from the first to the last value that it was fitted to."""
    if wear is None:
        return ""
    places = [
        (day, wear.level_mm + wear.per_day.value_mm * (day - wear.day))
        for day in (wear.from_day, wear.day)
    ]
    return "M" + "L".join(
        f"{field.across(day * DAY_S):.1f} {field.up(value):.1f}" for day, value in places
    )


def _series(field: Field, values: Sequence[FleetValue], place: int, station: str) -> Markup:
    own = [value for value in values if value.station == station]
    mark = _MARKS[place % len(_MARKS)]
    return element(
        "g",
        element("path", d="".join(_bars(field, own)), class_="bars"),
        element("path", d="".join(f"M{x:.1f} {y:.1f}{mark}" for x, y in _places(field, own))),
        class_=_colour(place),
    )


def _bars(field: Field, values: Iterable[FleetValue]) -> Iterator[str]:
    for value in values:
        high, low = field.up(value.value + value.u95), field.up(value.value - value.u95)
        yield f"M{field.across(value.at.timestamp()):.1f} {high:.1f}V{low:.1f}"


def _places(field: Field, values: Iterable[FleetValue]) -> Iterator[tuple[float, float]]:
    for value in values:
        yield field.across(value.at.timestamp()), field.up(value.value)
