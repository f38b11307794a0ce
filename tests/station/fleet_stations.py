"""Stations that send to a fleet, and what the fleet then has of them."""

import threading
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta

from newest_schema import make_store
from sqlalchemy import func, select

from measure import Alarm, Limits, Placing, Side, Status
from station.errors import StoreUnusable
from station.fleet import Fleet, Pusher, migrate_fleet
from station.fleet.tables import FleetAxle, FleetPass, FleetWheel
from station.store import (
    Actor,
    AxleWheel,
    Calibration,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    Recording,
    Store,
    activate,
    sqlite_url,
)
from station.store.measured import add_measurements, replace_axles

BEGAN = datetime(2026, 7, 1, tzinfo=UTC)
NEVER = threading.Event()


class Sending:
    """A station with its store, whose trains are simulated, and what sends for it."""

    def __init__(self, store, fleet, name, *, ahead=timedelta(0), changes_in_batch=20, limits=None):
        self.store = store
        self.name = name
        self.ahead = ahead
        self.fleet = fleet
        self.changes_in_batch = changes_in_batch
        self.limits = limits or Limits.default()

    def now(self):
        return datetime.now(UTC) + self.ahead

    def push(self, fleet=None, stop=NEVER):
        pusher = Pusher(
            self.store,
            fleet or self.fleet,
            station=self.name,
            name=f"station {self.name}",
            limits=self.limits,
            profiles=False,
            now=self.now,
            changes_in_batch=self.changes_in_batch,
        )
        return pusher.push(stop)

    def train(self, number, *, axles=2, value=30.0, u95=0.05, at=None, **more):
        """Have a train pass, measured, with its axles: as the worker leaves it."""
        at = at or BEGAN + timedelta(days=number) + self.ahead
        name = f"p{number:05}"
        with self.store.change() as session:
            if session.get(Calibration, "c") is None:
                session.add(calibration("c"))
            session.add(Pass(id=name, state=PassState.DONE, opened_at=at, axles=axles))
            session.flush()
            self.measure(session, name, axles, value, u95, at, **more)
        return name

    def measure(self, session, name, axles, value, u95, at, *, wheelset="ws", alarm=Alarm.NONE):
        recording = f"{name}.left"
        session.add(
            Recording(
                id=recording,
                sensor="left",
                pass_id=name,
                path=f"{name}.mcap",
                opened_at=at,
                calibration_id="c",
                recovered=False,
            )
        )
        session.flush()
        rows = [
            Measurement(
                recording_id=recording,
                frame=axle,
                calibration_id="c",
                sensor="left",
                pass_id=name,
                reference="S1002",
                software="-",
                measured_at=at,
                wheel=wheel(value, u95, alarm),
            )
            for axle in range(axles)
        ]
        add_measurements(session, rows)
        replace_axles(session, name, [axle_wheel(name, row, wheelset) for row in rows])


def calibration(name):
    return Calibration(
        id=name,
        state=CalibrationState.READY,
        sensor="left",
        target="dots:7x8:12",
        method="joint",
        recording_ids={"recordings": [], "laser_off": []},
        created_at=BEGAN,
        job_id="-",
        document='{"rms": {"dots_px": 0.11, "stripe_px": 0.22}}',
        passed=True,
    )


def wheel(value, u95=0.05, alarm=Alarm.NONE):
    reading = {"value": value, "u95": u95, "status": Status.OK.value, "alarm": alarm.value}
    return {"flange_height": reading, "diameter": None, "reason": None}


def axle_wheel(of_pass, row, wheelset, placing=Placing.CERTAIN):
    return AxleWheel(
        pass_id=of_pass,
        place=row.frame + 1,
        side=Side.LEFT,
        number=row.frame + 1,
        placing=placing,
        measurement_id=row.id,
        others={"measurements": []},
        wheelset=f"{wheelset}-{row.frame}",
        wheelset_side=Side.LEFT,
        jumps={},
    )


def counts(fleet, station=None):
    """Passes, wheels and axles that the fleet has, superseded ones left out."""
    with fleet.look() as session:
        found = []
        for table, of_pass in ((FleetPass, "id"), (FleetWheel, "pass_id"), (FleetAxle, "pass_id")):
            query = (
                select(func.count())
                .select_from(table)
                .join(
                    FleetPass,
                    (FleetPass.station == table.station)
                    & (FleetPass.epoch == table.epoch)
                    & (FleetPass.id == getattr(table, of_pass)),
                )
                if table is not FleetPass
                else select(func.count()).select_from(FleetPass)
            )
            query = query.where(~FleetPass.superseded)
            if station is not None:
                query = query.where(FleetPass.station == station)
            found.append(session.scalar(query))
    return tuple(found)


class CutOff:
    """A fleet whose line is cut at a transaction: before it is committed, or before that is told.

    Attributes
    ----------
    good
        Transactions that go well before.
    committed
        Whether the one that is cut off was committed, and only its acknowledgement lost.
    """

    def __init__(self, fleet, good, *, committed):
        self.fleet = fleet
        self.good = good
        self.committed = committed

    @contextmanager
    def change(self):
        self.good -= 1
        with self.fleet.change() as session:
            yield session
            if self.good < 0 and not self.committed:
                raise StoreUnusable("cut off")
        if self.good < 0:
            raise StoreUnusable("cut off")


@contextmanager
def fleet_of_two(folder, url):
    """Stations north and south, with empty stores, and the fleet they send to."""
    migrate_fleet(url)
    fleet = Fleet.open(url)
    stations = []
    for name in ("north", "south"):
        make_store(sqlite_url(folder / f"{name}.sqlite"))
        stations.append(Sending(Store.open(sqlite_url(folder / f"{name}.sqlite")), fleet, name))
    yield stations
    for each in stations:
        each.store.close()
    fleet.close()


def night_of(station, *, alarm=True):
    """Put a calibration in force, and have a night find that the sensor has moved."""
    with station.store.change() as session:
        other = calibration("d")
        session.add(other)
        session.flush()
        activate(session, other, sensor="left", seen=None, by=Actor("somebody"), at=BEGAN)
        session.add(night(alarm=alarm))


def night(*, alarm=True):
    return Recalibration(
        id="n",
        state=RecalibrationState.ASKING,
        sensor="left",
        ordered_at=BEGAN,
        ordered_by="the schedule",
        job_id="j",
        findings={},
        version=1,
        outcome="drifted",
        action="ask",
        alarm=alarm,
        present_version=1,
        figures={"sheet_rms_mm": 0.21, "sheet_largest_mm": 0.4},
        reasons={"reasons": ["it has moved"]},
    )
