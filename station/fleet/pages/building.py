"""All pages of a fleet from its database, at one moment: wheel by wheel, the overview last."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from sqlalchemy.orm import Session

from station.fleet.overview import sensor_healths, station_limits, station_states
from station.fleet.pages.addresses import OVERVIEW, SENSORS, names_address, wheel_address
from station.fleet.pages.folder import PagesFolder
from station.fleet.pages.frame import with_notice
from station.fleet.pages.overview_page import Overview, overview_page, page_of_nothing
from station.fleet.pages.sensors import sensors_page
from station.fleet.pages.wheel_lists import group_page, named_groups
from station.fleet.pages.wheel_page import wheel_page
from station.fleet.receiving import fleet_now
from station.fleet.standing import StationLimits, WheelStanding, wheel_standing
from station.fleet.trends import fleet_trend, measured_wheelsets
from station.fleet.wording import moment


@dataclass(frozen=True, slots=True)
class PagesWritten:
    """What became of the pages: how many there are, were new or changed, and went."""

    pages: int
    written: int
    removed: int


def write_pages(session: Session, root: Path, *, last: int, due_after: timedelta) -> PagesWritten:
    """Write the pages of a fleet; those that have not changed are left as they are.

    Parameters
    ----------
    last
        Passes of each wheel that are shown, the newest.
    due_after
        A calibration is due so long after it was made.

    Raises
    ------
    InputUnusable
        If the folder cannot be written, or holds something else.
    StoreUnusable
        If the database stops answering; the pages there are whole, the overview that before.
    """
    folder = PagesFolder.prepared(root)
    limits = station_limits(session)
    wheels = list(_put_wheels(session, folder, limits, last))
    groups = named_groups(wheels)
    for number, group in enumerate(groups, start=1):
        folder.put(names_address(number), group_page(group))
    at, sensors = fleet_now(session), sensor_healths(session)
    overview = Overview(at, station_states(session), sensors, wheels, due_after)
    folder.put(SENSORS, sensors_page(sensors, due_after, at))
    folder.put(OVERVIEW, overview_page(overview, groups))
    return PagesWritten(len(folder.kept), folder.written, folder.remove_others())


def _put_wheels(
    session: Session, folder: PagesFolder, limits: StationLimits, last: int
) -> Iterator[WheelStanding]:
    for wheelset in measured_wheelsets(session):
        trend = fleet_trend(session, wheelset, most=last)
        for side in trend.sides:
            if side.quantities:
                folder.put(wheel_address(wheelset, side.side), wheel_page(trend, side, limits))
                yield wheel_standing(wheelset, side, limits)


def note_unreached(root: Path, why: str) -> None:
    """Say on the overview that the fleet's database was not reached; what it tells is of before.

    Raises
    ------
    InputUnusable
        If the folder cannot be written, or holds something else.
    """
    folder = PagesFolder.prepared(root)
    notice = f"The fleet was not reached at {moment(datetime.now(UTC))}: {why}"
    before = folder.overview()
    text = page_of_nothing(notice) if before is None else with_notice(before, notice)
    folder.put(OVERVIEW, text)
