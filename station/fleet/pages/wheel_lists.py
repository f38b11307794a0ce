"""Lists of wheels: those that matter first, and all of them by name."""

import re
from collections.abc import Iterable, Sequence

from station.fleet.pages.addresses import names_address, wheel_address
from station.fleet.pages.frame import page
from station.fleet.pages.parts import (
    NAMES,
    SIDES,
    UNKNOWN,
    alarm_badge,
    card,
    empty,
    mm,
    nowrap,
    table,
    two_lines,
)
from station.fleet.pages.until import expected, interval, rate_and_u95
from station.fleet.standing import (
    QuantityStanding,
    WheelStanding,
    fastest_first,
    nearest_first,
    soonest_first,
)
from station.fleet.wording import moment
from station.report import Child, Markup, count, element

_SHOWN = 20
NAMES_IN_GROUP = 100
_NUMBERS = re.compile(r"(\d+)")


def matter_first(wheels: Sequence[WheelStanding]) -> Markup:
    """Return the wheels that somebody has to plan for."""
    soon, near, fast = soonest_first(wheels), nearest_first(wheels), fastest_first(wheels)
    if not wheels:
        none = "No wheel has been measured at a place that is certain; are consists told?"
        return card("Wheels that matter first", empty(none), id_="wheels")
    return element(
        "div",
        _list(
            "At their limit soonest",
            "The date at which the line of wear meets the limit, with its 95 % interval; wheels "
            "whose wear is not known well enough for a last date are left out.",
            ((each, each.soonest) for each in soon[:_SHOWN]),
            "No wheel is surely on its way to a limit.",
        ),
        _list(
            "Nearest to a limit",
            "By what is left to the limits of the stations that measured the wheel.",
            ((each, each.nearest) for each in near[:_SHOWN]),
            "No station has told its limits.",
        ),
        _list(
            "Worn fastest",
            "By what the rate is at least: its 95 % interval is taken off.",
            ((each, each.fastest) for each in fast[:_SHOWN]),
            "No wheel surely wears: too few passes, or too short a time.",
        ),
        id="wheels",
    )


def _list(
    title: str,
    hint: str,
    wheels: Iterable[tuple[WheelStanding, QuantityStanding | None]],
    none: str,
) -> Markup:
    rows = [_row(wheel, standing) for wheel, standing in wheels if standing is not None]
    if not rows:
        return card(title, empty(none))
    heads = ("Wheel", "Quantity", "Last", "Left", "In 30 days", "At its limit", "Now")
    return card(title, element("p", hint, class_="hint"), table(title, heads, rows))


def _row(wheel: WheelStanding, standing: QuantityStanding) -> tuple[Child, ...]:
    last = standing.last
    return (
        wheel_link(wheel, f"{wheel.wheelset}, {SIDES[wheel.side]}", up=""),
        NAMES[standing.quantity],
        two_lines(mm(last.value), f"\N{PLUS-MINUS SIGN} {mm(last.u95)}"),
        nowrap(mm(standing.margin_mm)),
        two_lines(*rate_and_u95(standing.wear)),
        two_lines(expected(standing), interval(standing)),
        alarm_badge(wheel.alarm),
    )


def wheel_link(wheel: WheelStanding, text: str, *, up: str) -> Markup:
    """Return a link to a wheel's page."""
    return element("a", text, href=f"{up}{wheel_address(wheel.wheelset, wheel.side)}")


def named_groups(wheels: Sequence[WheelStanding]) -> list[list[WheelStanding]]:
    """Return the wheels in the order of their wheelsets' names, numbers by value, in groups."""
    names = sorted({each.wheelset for each in wheels}, key=_in_order)
    place = {name: at // NAMES_IN_GROUP for at, name in enumerate(names)}
    ordered = sorted(wheels, key=lambda each: (_in_order(each.wheelset), each.side))
    groups: list[list[WheelStanding]] = [[] for _ in range(-(-len(names) // NAMES_IN_GROUP))]
    for each in ordered:
        groups[place[each.wheelset]].append(each)
    return groups


def _in_order(name: str) -> tuple[list[tuple[int, str]], str]:
    parts = _NUMBERS.split(name)
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts], name


def find_a_wheelset(groups: Sequence[Sequence[WheelStanding]]) -> Markup:
    """Return the groups of names, as a register has them."""
    if not groups:
        return card("Find a wheelset", empty("There is none yet."), id_="find")
    total = len({each.wheelset for group in groups for each in group})
    links = (
        element("li", element("a", _range(group), href=names_address(number)))
        for number, group in enumerate(groups, start=1)
    )
    return card(
        "Find a wheelset",
        element("p", f"{count(total, 'wheelset')}, by name.", class_="hint"),
        element("ul", links, class_="groups"),
        id_="find",
    )


def _range(group: Sequence[WheelStanding]) -> str:
    first, last = group[0].wheelset, group[-1].wheelset
    return first if first == last else f"{first} \N{EN DASH} {last}"


def group_page(group: Sequence[WheelStanding]) -> str:
    """Return the page of a group of names, a row a wheel."""
    title = f"Wheelsets {_range(group)}"
    heads = ("Wheel", "Last pass", "Stations", "Nearest to", "Left", "At its limit", "Now")
    return page(
        title,
        element("h1", title),
        card("Wheels", table(title, heads, (_named(each) for each in group))),
        up="../",
    )


def _named(wheel: WheelStanding) -> tuple[Child, ...]:
    near, soon = wheel.nearest, wheel.soonest
    return (
        wheel_link(wheel, f"{wheel.wheelset}, {SIDES[wheel.side]}", up="../"),
        nowrap(moment(wheel.last_at)),
        ", ".join(wheel.stations),
        UNKNOWN if near is None else NAMES[near.quantity],
        nowrap(UNKNOWN if near is None else mm(near.margin_mm)),
        nowrap(UNKNOWN if soon is None else expected(soon)),
        alarm_badge(wheel.alarm),
    )
