"""What the fleet knows of its stations, and of the calibrations on their sensors."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import and_, func, select
from sqlalchemy.orm import Session, aliased

from measure import Limit, Quantity
from station.fleet.receiving import fleet_now
from station.fleet.tables import (
    FleetAlarm,
    FleetCalibration,
    FleetEpoch,
    FleetPass,
    FleetRecalibration,
    FleetRefusal,
    FleetStation,
)
from station.fleet.told_limits import limits_told

MOST_STATIONS = 1000
MOST_SENSORS = 5000


@dataclass(frozen=True, slots=True)
class StationState:
    """A station, as the fleet heard of it last.

    Attributes
    ----------
    silent_s
        Since it was heard, by the fleet's clock.
    clock_ahead_s
        Of its clock against the fleet's, the way between them included.
    unsent, unsent_since
        Changes it had still to send when it was heard, and since when the oldest waited.
    epochs
        Lives of its store that the fleet knows; more than one where it was brought back.
    rivals
        Earlier lives that went on sending after a later one had begun: another station uses the
        name, or a copy of the store runs.
    refused
        Changes that the fleet's database did not take.
    alarms
        Readings at alarm level in its last pass.
    doubtful
        Its sensors whose calibration in force may measure wrongly.
    """

    station: str
    name: str
    software: str
    last_heard_at: datetime
    silent_s: float
    clock_ahead_s: float
    unsent: int
    unsent_since: datetime | None
    passes: int
    last_pass_at: datetime | None
    epochs: int
    rivals: int
    refused: int
    alarms: int
    doubtful: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SensorHealth:
    """The calibration in force on a sensor or rig, and what the last night said of it.

    Attributes
    ----------
    age_s
        Of the calibration, by the fleet's clock.
    drift_rms_mm, drift_largest_mm
        How far the last recalibration placed the working volume's points from it; None where no
        recalibration compared the two.
    doubtful
        Whether that raised an alarm against this very calibration.
    """

    station: str
    of: str
    name: str
    version: int
    calibration_id: str
    method: str | None
    created_at: datetime
    age_s: float
    passed: bool | None
    rms_dots_px: float | None
    rms_stripe_px: float | None
    checked_at: datetime | None
    outcome: str | None
    drift_rms_mm: float | None
    drift_largest_mm: float | None
    doubtful: bool


def station_states(session: Session) -> list[StationState]:
    """Return the stations by name, `MOST_STATIONS` of them at most."""
    now = fleet_now(session)
    doubtful: dict[str, list[str]] = {}
    for sensor in sensor_healths(session):
        if sensor.doubtful:
            doubtful.setdefault(sensor.station, []).append(sensor.name)
    rows = session.scalars(select(FleetStation).order_by(FleetStation.id).limit(MOST_STATIONS))
    return [_state(session, row, now, tuple(doubtful.get(row.id, ()))) for row in rows.all()]


def station_limits(session: Session) -> dict[str, dict[Quantity, Limit]]:
    """Return what each station judges its readings by, as far as it has told."""
    rows = session.execute(select(FleetStation.id, FleetStation.limits).limit(MOST_STATIONS))
    return {station: limits_told(told) for station, told in rows}


def _state(
    session: Session, row: FleetStation, now: datetime, doubtful: tuple[str, ...]
) -> StationState:
    passes = (
        select(func.count())
        .select_from(FleetPass)
        .where(FleetPass.station == row.id)
        .where(~FleetPass.superseded)
    )
    last = session.scalar(
        select(FleetPass)
        .where(FleetPass.station == row.id)
        .where(~FleetPass.superseded)
        .order_by(FleetPass.opened_at.desc())
        .limit(1)
    )
    return StationState(
        station=row.id,
        name=row.name,
        software=row.software,
        last_heard_at=row.last_heard_at,
        silent_s=(now - row.last_heard_at).total_seconds(),
        clock_ahead_s=row.clock_ahead_s,
        unsent=row.unsent,
        unsent_since=row.unsent_since,
        passes=session.scalar(passes) or 0,
        last_pass_at=None if last is None else last.opened_at,
        epochs=_count(session, FleetEpoch, row.id),
        rivals=_rivals(session, row.id),
        refused=_count(session, FleetRefusal, row.id),
        alarms=0 if last is None else _alarms(session, last),
        doubtful=doubtful,
    )


def _count(session: Session, table: type[FleetEpoch | FleetRefusal], station: str) -> int:
    query = select(func.count()).select_from(table).where(table.station == station)
    return session.scalar(query) or 0


def _rivals(session: Session, station: str) -> int:
    later = aliased(FleetEpoch)
    overtaken = (
        select(later.epoch)
        .where(later.station == FleetEpoch.station)
        .where(later.epoch > FleetEpoch.epoch)
        .where(later.began_at < FleetEpoch.heard_at)
        .exists()
    )
    query = (
        select(func.count())
        .select_from(FleetEpoch)
        .where(FleetEpoch.station == station)
        .where(overtaken)
    )
    return session.scalar(query) or 0


def _alarms(session: Session, last: FleetPass) -> int:
    query = (
        select(func.count())
        .select_from(FleetAlarm)
        .where(FleetAlarm.station == last.station)
        .where(FleetAlarm.epoch == last.epoch)
        .where(FleetAlarm.pass_id == last.id)
        .where(FleetAlarm.alarm == "alarm")
    )
    return session.scalar(query) or 0


def sensor_healths(session: Session, *, station: str | None = None) -> list[SensorHealth]:
    """Return the calibrations in force, by station and sensor, `MOST_SENSORS` at most."""
    now = fleet_now(session)
    nights = _last_nights(session)
    return [
        _health(row, nights.get((row.station, row.name)) if row.of == "sensor" else None, now)
        for row in _in_force(session, station)
    ]


def _in_force(session: Session, station: str | None) -> Sequence[FleetCalibration]:
    """Return the last activation of each sensor and rig, of the last epoch that tells of any."""
    epoch = aliased(FleetCalibration)
    last_epoch = (
        select(func.max(epoch.epoch))
        .where(epoch.station == FleetCalibration.station)
        .where(epoch.of == FleetCalibration.of)
        .where(epoch.name == FleetCalibration.name)
        .scalar_subquery()
    )
    version = aliased(FleetCalibration)
    last_version = (
        select(func.max(version.version))
        .where(version.station == FleetCalibration.station)
        .where(version.epoch == FleetCalibration.epoch)
        .where(version.of == FleetCalibration.of)
        .where(version.name == FleetCalibration.name)
        .scalar_subquery()
    )
    query = (
        select(FleetCalibration)
        .where(FleetCalibration.epoch == last_epoch)
        .where(FleetCalibration.version == last_version)
        .order_by(FleetCalibration.station, FleetCalibration.of.desc(), FleetCalibration.name)
        .limit(MOST_SENSORS)
    )
    if station is not None:
        query = query.where(FleetCalibration.station == station)
    return session.scalars(query).all()


def _last_nights(session: Session) -> dict[tuple[str, str], FleetRecalibration]:
    """Return the last recalibration of each sensor that came to a decision."""
    other = aliased(FleetRecalibration)
    last = (
        select(
            other.station,
            other.sensor,
            func.max(other.ordered_at).label("ordered_at"),
        )
        .where(other.outcome.is_not(None))
        .where(~other.superseded)
        .group_by(other.station, other.sensor)
        .subquery()
    )
    rows = session.scalars(
        select(FleetRecalibration)
        .join(
            last,
            and_(
                FleetRecalibration.station == last.c.station,
                FleetRecalibration.sensor == last.c.sensor,
                FleetRecalibration.ordered_at == last.c.ordered_at,
            ),
        )
        .where(FleetRecalibration.outcome.is_not(None))
        .where(~FleetRecalibration.superseded)
        .limit(MOST_SENSORS)
    )
    return {(row.station, row.sensor): row for row in rows}


def _health(row: FleetCalibration, night: FleetRecalibration | None, now: datetime) -> SensorHealth:
    figures = (night.figures or {}) if night is not None else {}
    against = night is not None and _is_against(night, row)
    return SensorHealth(
        station=row.station,
        of=row.of,
        name=row.name,
        version=row.version,
        calibration_id=row.calibration_id,
        method=row.method,
        created_at=row.created_at,
        age_s=(now - row.created_at).total_seconds(),
        passed=row.passed,
        rms_dots_px=row.rms_dots_px,
        rms_stripe_px=row.rms_stripe_px,
        checked_at=None if night is None else night.ended_at or night.ordered_at,
        outcome=None if night is None else night.outcome,
        drift_rms_mm=figures.get("sheet_rms_mm"),
        drift_largest_mm=figures.get("sheet_largest_mm"),
        doubtful=night is not None and against and bool(night.alarm) and night.state != "refused",
    )


def _is_against(night: FleetRecalibration, row: FleetCalibration) -> bool:
    return (night.epoch, night.present_version) == (row.epoch, row.version)
