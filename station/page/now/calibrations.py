"""The calibration that a sensor, or a rig, measures by: how old, by whom, how good."""

import json
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import lru_cache

from sqlalchemy.orm import Session

from station.store import Calibration, RigCalibration, active, active_rig

_MOST_DOCUMENTS = 32
_DAY = timedelta(days=1)


@dataclass(frozen=True, slots=True)
class Figures:
    """How good a calibration is, as its document says."""

    dots_px: float | None = None
    """Root mean square of the residuals of dots, px; None where it has none, as of a rig."""
    stripe_px: float | None = None
    passed: int = 0
    """Gates that were passed."""
    gates: int = 0


@dataclass(frozen=True, slots=True)
class InForce:
    """A calibration in force."""

    calibration: str
    created_at: datetime
    activated_at: datetime
    activated_by: str
    passed: bool | None
    """Whether its figures keep the limits."""
    figures: Figures

    def age_s(self, now: datetime) -> float:
        """Return how old it is, s; beyond a day whole days: nobody reads its minutes."""
        age = max(now - self.created_at, timedelta())
        return (age if age < _DAY else timedelta(days=age.days)).total_seconds()


def of_sensor(session: Session, sensor: str) -> InForce | None:
    """Return the calibration in force on a sensor, or None."""
    present = active(session, sensor)
    if present is None:
        return None
    row = session.get_one(Calibration, present.calibration_id)
    return InForce(
        row.id,
        row.created_at,
        present.activated_at,
        present.activated_by,
        row.passed,
        figures_in(row.document),
    )


def of_rig(session: Session, rig: str) -> InForce | None:
    """Return the calibration in force on a rig, or None."""
    present = active_rig(session, rig)
    if present is None:
        return None
    row = session.get_one(RigCalibration, present.rig_calibration_id)
    return InForce(
        row.id,
        row.created_at,
        present.activated_at,
        present.activated_by,
        row.passed,
        figures_in(row.document),
    )


@lru_cache(maxsize=_MOST_DOCUMENTS)  # of up to 100 kB each, the same ones every second
def figures_in(document: str | None) -> Figures:
    """Return the figures of a calibration.json or rig.json; none where there is no document.

    >>> figures_in('{"rms": {"dots_px": 0.05, "stripe_px": 0.1}, "quality": {}}').dots_px
    0.05
    """
    if document is None:
        return Figures()
    told = json.loads(document)
    rms, gates = told.get("rms") or {}, list((told.get("quality") or {}).values())
    return Figures(
        dots_px=rms.get("dots_px"),
        stripe_px=rms.get("stripe_px"),
        passed=sum(bool(gate["passed"]) for gate in gates),
        gates=len(gates),
    )
