"""The page that a planner opens first."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from station.fleet.overview import SensorHealth, StationState
from station.fleet.pages.frame import page
from station.fleet.pages.sensors import sensors_card
from station.fleet.pages.stations import stations_card
from station.fleet.pages.wheel_lists import find_a_wheelset, matter_first
from station.fleet.standing import WheelStanding
from station.fleet.wording import moment
from station.report import element


@dataclass(frozen=True, slots=True)
class Overview:
    """What the fleet knows at one moment, by its own clock."""

    at: datetime
    stations: Sequence[StationState]
    sensors: Sequence[SensorHealth]
    wheels: Sequence[WheelStanding]
    due_after: timedelta


def overview_page(
    overview: Overview, groups: Sequence[Sequence[WheelStanding]], *, notice: str | None = None
) -> str:
    """Return the overview; `groups` are the wheels by name."""
    said = f"As the fleet knew it at {moment(overview.at)}. All times are UTC."
    return page(
        "Overview",
        element("h1", "Fleet"),
        element("p", said, class_="hint"),
        stations_card(overview.stations),
        sensors_card(overview.sensors, overview.due_after),
        matter_first(overview.wheels),
        find_a_wheelset(groups),
        notice=notice,
    )


def page_of_nothing(notice: str) -> str:
    """Return an overview where the fleet was never reached."""
    return page("Overview", element("h1", "Fleet"), notice=notice)
