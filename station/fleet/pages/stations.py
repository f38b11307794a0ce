"""The stations: when each was heard, what it has still to send, what it says of its last train."""

from collections.abc import Sequence

from station.fleet.overview import StationState
from station.fleet.pages.parts import UNKNOWN, badge, card, empty, table, two_lines
from station.fleet.wording import moment, remarks_on, span
from station.report import Child, Markup, count, element

_SILENT_S = 86_400.0
"""A station that was not heard for a day is switched off, or its link is down."""


def stations_card(states: Sequence[StationState]) -> Markup:
    """Return a row for each station."""
    if not states:
        return card("Stations", empty("No station has sent anything yet."), id_="stations")
    heads = ("Station", "Last heard", "Alarms", "Passes", "To send", "Remarks")
    rows = (_row(state) for state in states)
    return card("Stations", table("Stations", heads, rows), id_="stations")


def _row(state: StationState) -> tuple[Child, ...]:
    others = [each for each in remarks_on(state) if "alarms in its last pass" not in each]
    return (
        element("span", state.station, element("span", state.name, class_="below")),
        _heard(state),
        badge(f"{state.alarms} in its last pass", "bad") if state.alarms else UNKNOWN,
        _passes(state),
        _behind(state),
        "; ".join(others) or UNKNOWN,
    )


def _heard(state: StationState) -> Child:
    ago = f"{span(state.silent_s)} ago"
    if state.silent_s < _SILENT_S:
        return two_lines(ago, moment(state.last_heard_at))
    text = element("span", moment(state.last_heard_at), class_="below")
    return element("td", badge(f"silent, {ago}", "warn"), text, class_="nowrap")


def _passes(state: StationState) -> Child:
    if state.last_pass_at is None:
        return f"{state.passes}"
    return two_lines(f"{state.passes}", f"last {moment(state.last_pass_at)}")


def _behind(state: StationState) -> Child:
    if state.unsent == 0:
        return "nothing"
    since = UNKNOWN if state.unsent_since is None else f"since {moment(state.unsent_since)}"
    return two_lines(count(state.unsent, "change"), since)
