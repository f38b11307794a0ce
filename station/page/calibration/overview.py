"""The page as it opens: what is in force on each sensor and rig, and what waits for somebody."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from station.operations import Station
from station.store import (
    JOB,
    Calibration,
    CalibrationSession,
    Job,
    JobKind,
    Recalibration,
    RigCalibration,
    SessionState,
    active,
    active_rig,
    the,
)
from station.store.lists import sessions_page
from station.store.recalibrations import alarm_of, asking_recalibrations, last_decided

_KINDS = (JobKind.CALIBRATE, JobKind.CALIBRATE_RIG, JobKind.RECALIBRATE, JobKind.MEASURE_AGAIN)
_SESSIONS = 8


@dataclass(frozen=True, slots=True)
class InForce:
    """What a sensor or a rig measures with.

    Attributes
    ----------
    kind
        "sensor" or "rig".
    calibration
        Its id; None where nothing is in force, and then all else is None too.
    gates, gates_passed
        How many gates it has, and how many it passed.
    sheet_sigma_mm
        What the calibration leaves open of the sheet; None of a rig.
    alarm
        Why somebody must look; None where nobody must.
    checked_at, outcome
        The last recalibration that came to a decision, and which.
    """

    kind: str
    name: str
    calibration: str | None
    made_at: datetime | None = None
    since: datetime | None = None
    by: str | None = None
    gates: int = 0
    gates_passed: int = 0
    sheet_sigma_mm: float | None = None
    alarm: str | None = None
    checked_at: datetime | None = None
    outcome: str | None = None


@dataclass(frozen=True, slots=True)
class Overview:
    """The page as it opens."""

    in_force: tuple[InForce, ...]
    asking: tuple[Recalibration, ...]
    sessions: Sequence[CalibrationSession]
    jobs: Sequence[Job]

    @property
    def open_sessions(self) -> bool:
        """Whether pictures are being taken."""
        return any(each.state is SessionState.OPEN for each in self.sessions)


def overview_of(session: Session, station: Station) -> Overview:
    """Return the page as it opens."""
    sensors = [each.id for each in station.settings.sensors]
    asking = [row for name in sensors for row in asking_recalibrations(session, name)]
    return Overview(
        in_force=(
            *(_of_sensor(session, name) for name in sensors),
            *(_of_rig(session, each.id) for each in station.settings.rigs),
        ),
        asking=tuple(asking),
        sessions=sessions_page(session, limit=_SESSIONS).rows,
        jobs=tuple(_jobs(session)),
    )


def _of_sensor(session: Session, name: str) -> InForce:
    activation = active(session, name)
    if activation is None:
        return InForce("sensor", name, None)
    row = the(session, Calibration, activation.calibration_id)
    alarm, decided = alarm_of(session, name), last_decided(session, name)
    return InForce(
        kind="sensor",
        name=name,
        calibration=row.id,
        made_at=row.created_at,
        since=activation.activated_at,
        by=activation.activated_by,
        **_gates(row.document),
        alarm=None if alarm is None else "; ".join((alarm.reasons or {}).get("reasons", [])),
        checked_at=None if decided is None else decided.ended_at,
        outcome=None if decided is None else decided.outcome,
    )


def _of_rig(session: Session, name: str) -> InForce:
    activation = active_rig(session, name)
    if activation is None:
        return InForce("rig", name, None)
    row = the(session, RigCalibration, activation.rig_calibration_id)
    return InForce(
        kind="rig",
        name=name,
        calibration=row.id,
        made_at=row.created_at,
        since=activation.activated_at,
        by=activation.activated_by,
        **_gates(row.document),
    )


def _gates(document: str | None) -> dict[str, Any]:
    # Of a document of a hundred kilobytes three figures: not worth checking all of it each time.
    quality = json.loads(document)["quality"] if document else {}
    return {
        "gates": len(quality),
        "gates_passed": sum(gate["passed"] for gate in quality.values()),
        "sheet_sigma_mm": quality.get("sheet_sigma_mm", {}).get("value"),
    }


def _jobs(session: Session) -> Iterator[Job]:
    yield from session.scalars(
        select(Job)
        .where(Job.kind.in_([kind.value for kind in _KINDS]))
        .where(Job.state.in_(JOB.unfinished))
        .order_by(Job.created_at.desc())
    )
