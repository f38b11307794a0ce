"""The report of a calibration: what it is, whether it may measure, what is in force instead."""

from dataclasses import dataclass

from sqlalchemy.orm import Session

from station.documents import CalibrationDocument, RigDocument
from station.page.calibration.made import outcome_of
from station.store import (
    JOB,
    Calibration,
    CalibrationState,
    Job,
    RigCalibration,
    active,
    active_rig,
    the,
)

_LOWER_LIMITS = frozenset({"views_used", "showings_used"})


@dataclass(frozen=True, slots=True)
class GateShown:
    """One demand on a calibration, its figure and its limit."""

    name: str
    value: float
    limit: float
    passed: bool
    at_least: bool

    @property
    def share(self) -> float:
        """The figure as part of the limit, 0 to 2: what its bar shows."""
        return min(max(self.value / self.limit, 0.0), 2.0) if self.limit > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Report:
    """A calibration of a sensor or of a rig.

    Attributes
    ----------
    kind
        "sensor" or "rig".
    of
        Its name.
    outcome
        As of `Made`.
    document
        Its file; None where it is not ready.
    job
        Where it is solved; None of one that was taken in.
    present, version
        The calibration in force and the version that is to be sent to change it; None and 0 where
        nothing is.
    """

    id: str
    kind: str
    of: str
    outcome: str
    row: Calibration | RigCalibration
    document: CalibrationDocument | RigDocument | None
    job: Job | None
    present: str | None
    version: int

    @property
    def solving(self) -> bool:
        """Whether it is still being solved."""
        return self.job is not None and not JOB.ended(self.job.state)

    @property
    def in_force(self) -> bool:
        """Whether it is what is measured with."""
        return self.present == self.id

    @property
    def can_be_decided(self) -> bool:
        """Whether it may be brought into force, or refused."""
        ready = self.row.state is CalibrationState.READY
        return ready and not self.in_force and self.row.refused_at is None

    @property
    def gates(self) -> tuple[GateShown, ...]:
        """Its gates; those not passed first."""
        quality = {} if self.document is None else self.document.quality
        shown = (
            GateShown(name, gate.value, gate.limit, gate.passed, name in _LOWER_LIMITS)
            for name, gate in quality.items()
        )
        return tuple(sorted(shown, key=lambda gate: gate.passed))


def report_of(session: Session, calibration_id: str) -> Report:
    """Return the report of a sensor's calibration.

    Raises
    ------
    NotFound
        If there is none of that id.
    """
    row = the(session, Calibration, calibration_id)
    present = active(session, row.sensor)
    document = CalibrationDocument.model_validate_json(row.document) if row.document else None
    return Report(
        id=row.id,
        kind="sensor",
        of=row.sensor,
        outcome=outcome_of(row),
        row=row,
        document=document,
        job=session.get(Job, row.job_id),
        present=None if present is None else present.calibration_id,
        version=0 if present is None else present.version,
    )


def rig_report_of(session: Session, calibration_id: str) -> Report:
    """Return the report of a rig's calibration; NotFound where there is none of that id."""
    row = the(session, RigCalibration, calibration_id)
    present = active_rig(session, row.rig)
    return Report(
        id=row.id,
        kind="rig",
        of=row.rig,
        outcome=outcome_of(row),
        row=row,
        document=RigDocument.model_validate_json(row.document) if row.document else None,
        job=None if row.job_id is None else session.get(Job, row.job_id),
        present=None if present is None else present.rig_calibration_id,
        version=0 if present is None else present.version,
    )
