"""What comes out over HTTP of recalibrations, and of the line of a sensor's calibrations."""

from collections.abc import Mapping
from datetime import datetime
from typing import Self

from station.api.answers import Out
from station.api.paging import next_of
from station.recalibration import Action, Outcome
from station.store import Activation, Calibration, Recalibration, RecalibrationState
from station.store.lists import Page


class RecalibrationModel(Out):
    """A recalibration: what was found, what was decided, and why."""

    id: str
    state: RecalibrationState
    sensor: str
    due_at: datetime | None
    """Its moment of the schedule; null of one that somebody ordered."""
    ordered_at: datetime
    ordered_by: str
    ended_at: datetime | None
    job: str
    recordings: list[str]
    """What it was made from."""
    piece_recordings: list[str]
    """Those that show the reference piece."""
    calibration: str | None
    """The new calibration; null where none could be solved."""
    compared_with: str | None
    """The calibration in force that it was held against."""
    compared_with_version: int | None
    outcome: Outcome | None
    action: Action | None
    alarm: bool | None
    """Whether somebody must look: the calibration in force may measure wrongly."""
    reasons: list[str]
    figures: dict[str, float]
    """Lengths in mm, and what else the decision rests on."""
    piece: dict[str, str]
    """What the reference piece said, by the new calibration and by that in force."""
    reason: str | None
    """Why it came to no decision, where it failed."""
    activated_version: int | None
    """Where its calibration came into force."""
    answered_by: str | None
    answered_at: datetime | None
    answer: str | None
    """Why the person answered so."""
    measuring_job: str | None
    """The job that measures passes again."""
    version: int

    @classmethod
    def of(cls, row: Recalibration) -> Self:
        taken = row.taken or {}
        made = {
            "job": row.job_id,
            "recordings": taken.get("recordings", taken.get("named", [])),
            "piece_recordings": taken.get("piece", []),
            "calibration": row.calibration_id,
            "compared_with": row.present_id,
            "compared_with_version": row.present_version,
            "reasons": (row.reasons or {}).get("reasons", []),
            "figures": row.figures or {},
            "piece": row.findings.get("piece", {}),
            "measuring_job": row.measuring_job_id,
        }
        same = cls.model_fields.keys() - made.keys()
        return cls(**made, **{name: getattr(row, name) for name in same})


class RecalibrationsPage(Out):
    """Some recalibrations; `next` is the `before` of the next page, absent on the last."""

    recalibrations: list[RecalibrationModel]
    next: str | None

    @classmethod
    def of(cls, page: Page[Recalibration]) -> Self:
        return cls(
            recalibrations=[RecalibrationModel.of(row) for row in page.rows],
            next=next_of(page.rows, lambda row: (row.ordered_at, row.id), more=page.more),
        )


class InForceModel(Out):
    """A calibration that came into force on a sensor, and why."""

    version: int
    calibration: str
    activated_at: datetime
    activated_by: str
    method: str
    created_at: datetime
    passed: bool | None
    """Whether its figures keep the limits."""
    recalibration: str | None
    """What brought it; null where a person chose it."""
    outcome: Outcome | None
    reasons: list[str]
    figures: dict[str, float]

    @classmethod
    def of(cls, row: Activation, calibration: Calibration, brought: Recalibration | None) -> Self:
        answer = [] if brought is None or brought.answer is None else [brought.answer]
        reasons = [] if brought is None else [*(brought.reasons or {}).get("reasons", []), *answer]
        return cls(
            version=row.version,
            calibration=calibration.id,
            activated_at=row.activated_at,
            activated_by=row.activated_by,
            method=calibration.method,
            created_at=calibration.created_at,
            passed=calibration.passed,
            recalibration=None if brought is None else brought.id,
            outcome=None
            if brought is None or brought.outcome is None
            else Outcome(brought.outcome),
            reasons=reasons,
            figures={} if brought is None else brought.figures or {},
        )


class InForcePage(Out):
    """Some of a sensor's calibrations; `next` is the `before` of the next page."""

    sensor: str
    calibrations: list[InForceModel]
    next: int | None

    @classmethod
    def of(
        cls,
        sensor: str,
        page: Page[Activation],
        why: Mapping[int, tuple[Calibration, Recalibration | None]],
    ) -> Self:
        return cls(
            sensor=sensor,
            calibrations=[InForceModel.of(row, *why[row.version]) for row in page.rows],
            next=page.rows[-1].version if page.more else None,
        )
