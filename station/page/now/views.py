"""What the page shows of the station at one moment."""

from collections.abc import Sequence
from dataclasses import dataclass

from station.api import Parts
from station.operations import by_command
from station.page.now.disk import DiskNow, disk_now
from station.page.now.passing import PassNow, pass_now
from station.page.now.sensors import SensorCard, sensor_cards
from station.page.now.troubles import TroubleNow, troubles_now
from station.store import Job, unfinished_jobs


@dataclass(frozen=True, slots=True)
class NowView:
    """The station at one moment."""

    ready: bool
    """Whether the next train will be recorded and measured."""
    troubles: Sequence[TroubleNow]
    sensors: Sequence[SensorCard]
    running: PassNow | None
    jobs: Sequence[Job]
    disk: DiskNow | None
    sessions: Sequence[str]
    """Calibration sessions that hold a sensor."""
    by_command: Sequence[str]
    """Sensors whose frames are taken by command."""

    @property
    def desk(self) -> str:
        """What the buttons depend on: they are loaded anew when it changes."""
        if self.running is not None:
            return f"{self.running.row.id} {self.running.row.state}"
        return " ".join(["free", *self.sessions])


def now_view(parts: Parts) -> NowView:
    """Look at the station; a part that is away is shown as away and not waited for."""
    outlook, station = parts.lookout.look(), parts.station
    with station.store.look() as session:
        sensors = sensor_cards(session, station.settings, outlook)
        return NowView(
            ready=outlook.ready,
            troubles=troubles_now(outlook.troubles),
            sensors=sensors,
            running=pass_now(session, outlook.statuses),
            jobs=unfinished_jobs(session),
            disk=disk_now(station, session, outlook.statuses, station.now()),
            sessions=sorted({each.held_by for each in sensors if each.held_by is not None}),
            by_command=[each.id for each in by_command(station)],
        )
