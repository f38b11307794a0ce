"""The page of one wheel: each of its quantities over all stations, and all values as a table."""

from collections.abc import Iterator, Sequence
from datetime import datetime

from measure import Alarm, Quantity
from station.fleet.agreement import Agreement
from station.fleet.pages.addresses import wheel_address
from station.fleet.pages.chart import station_mark, trend_chart
from station.fleet.pages.frame import page
from station.fleet.pages.parts import (
    NAMES,
    SIDES,
    UNKNOWN,
    alarm_badge,
    badge,
    card,
    mm,
    nowrap,
    table,
)
from station.fleet.pages.until import sentence
from station.fleet.standing import QuantityStanding, StationLimits, quantity_standings
from station.fleet.trends import FleetSide, FleetTrend, FleetValue
from station.fleet.wording import moment
from station.report import Child, Markup, count, element


def wheel_page(trend: FleetTrend, side: FleetSide, limits: StationLimits) -> str:
    """Return the page of a wheel of a wheelset."""
    stations = sorted({v.station for each in side.quantities.values() for v in each.values})
    standings = quantity_standings(side, limits)
    title = f"{trend.wheelset}, {SIDES[side.side]}"
    return page(
        title,
        element("h1", title),
        _others(trend, side),
        _legend(stations),
        element("div", (_chart(side, each, stations) for each in standings), class_="charts"),
        card("All values", _values(side)),
        up="../",
    )


def _others(trend: FleetTrend, side: FleetSide) -> Child:
    links = [
        element("a", SIDES[each.side], href=f"../{wheel_address(trend.wheelset, each.side)}")
        for each in trend.sides
        if each.side is not side.side
    ]
    return element("p", "On the same axle: ", links) if links else ()


def _legend(stations: Sequence[str]) -> Markup:
    marks = (element("li", station_mark(place), name) for place, name in enumerate(stations))
    return element("ul", marks, class_="legend", aria_label="Stations")


def _chart(side: FleetSide, standing: QuantityStanding, stations: Sequence[str]) -> Markup:
    found = side.quantities[standing.quantity]
    name = NAMES[standing.quantity]
    last = standing.last
    shown = f"{mm(last.value)} \N{PLUS-MINUS SIGN} {mm(last.u95)}"
    drawn = (
        f"{name}: {count(len(found.values), 'value')} from {found.values[0].at:%Y-%m-%d} to "
        f"{last.at:%Y-%m-%d}, the last {shown} at {last.station}. The table below has all."
    )
    return element(
        "section",
        element("h2", name),
        element(
            "p", f"{shown} at {last.station} ", alarm_badge(last.alarm) if _is_alarm(last) else ()
        ),
        element(
            "figure",
            trend_chart(found, standing, stations, drawn),
            element("figcaption", sentence(standing), " ", _disagreeing(found.agreement)),
        ),
        class_="card",
    )


def _is_alarm(value: FleetValue) -> bool:
    return value.alarm in {Alarm.ALARM, Alarm.WARNING}


def _disagreeing(agreement: Agreement | None) -> str:
    """Tell which stations read it otherwise; that they agree is nothing to read about."""
    if agreement is None:
        return ""
    return " ".join(
        f"{each.station} reads {mm(each.offset_mm, signed=True)} \N{PLUS-MINUS SIGN} "
        f"{mm(each.u95_mm)} against {agreement.held_against}: they disagree."
        for each in agreement.offsets
        if not each.agrees
    )


def _values(side: FleetSide) -> Markup:
    """Return the values of all quantities, a row a pass, the newest first."""
    quantities = tuple(side.quantities)
    passes: dict[tuple[datetime, str, str], dict[Quantity, FleetValue]] = {}
    for quantity, found in side.quantities.items():
        for value in found.values:
            passes.setdefault((value.at, value.station, value.pass_id), {})[quantity] = value
    heads = ("Pass", "Station", *(NAMES[each] for each in quantities))
    rows = (_row(at, station, passes[at, station, id_], quantities) for at, station, id_ in
            sorted(passes, reverse=True))  # fmt: skip
    caption = "All values of the wheel with their u95, the newest pass first"
    return table(caption, heads, rows)


def _row(
    at: datetime, station: str, values: dict[Quantity, FleetValue], quantities: Sequence[Quantity]
) -> Iterator[Child]:
    yield element("span", moment(at), class_="nowrap")
    yield station
    for quantity in quantities:
        yield _value(values.get(quantity))


def _value(value: FleetValue | None) -> Child:
    if value is None:
        return UNKNOWN
    text = f"{mm(value.value)} \N{PLUS-MINUS SIGN} {mm(value.u95)}"
    if value.jump_mm is not None:
        return element("td", text, " ", badge(f"jumped {mm(value.jump_mm, signed=True)}", "bad"))
    if _is_alarm(value):
        return element("td", text, " ", alarm_badge(value.alarm))
    return nowrap(text)
