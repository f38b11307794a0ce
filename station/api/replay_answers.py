"""What comes out over HTTP of replays."""

from datetime import datetime
from typing import Self

from station.api.answers import Out
from station.api.paging import next_of
from station.operations import ReplayView
from station.store import JobState


class ReplayStepModel(Out):
    """What came of a recording, or of those that were measured together on a rig."""

    recordings: list[str]
    wheels: int | None
    """Wheels in it; null where it is not measured yet, or could not be."""
    added: int | None
    """Measurements that are new; the other wheels had been measured so before, with this result."""
    refused: str | None
    """Why it could not be measured."""


class ReplayModel(Out):
    """Recordings measured once more; its measurements are at /v1/measurements?replay=ID."""

    id: str
    state: JobState
    progress: float
    """Part done, 0 to 1."""
    ordered_at: datetime
    ordered_by: str
    ended_at: datetime | None
    job: str
    pass_id: str | None
    """Where a pass was named in place of recordings."""
    calibrations: dict[str, str]
    """By sensor."""
    rig_calibration: str | None
    reference: str
    steps: list[ReplayStepModel]
    measurements: int
    """How many it has come to, new ones and others."""
    added: int
    """How many of them are new: none where all had been measured so before."""
    reason: str | None
    """What could not be measured, and why."""

    @classmethod
    def of(cls, view: ReplayView) -> Self:
        row, job = view.row, view.job
        steps = [_step(names, row.results.get(names[0], {})) for names in row.steps["steps"]]
        return cls(
            id=row.id,
            state=job.state,
            progress=job.progress,
            ordered_at=row.ordered_at,
            ordered_by=row.ordered_by,
            ended_at=job.ended_at,
            job=job.id,
            pass_id=row.pass_id,
            calibrations=row.calibrations,
            rig_calibration=row.rig_calibration_id,
            reference=row.reference,
            steps=steps,
            measurements=view.measurements,
            added=sum(step.added or 0 for step in steps),
            reason=job.error,
        )


def _step(names: list[str], said: dict[str, int | str]) -> ReplayStepModel:
    told = {"wheels": None, "added": None, "refused": None} | said
    return ReplayStepModel.model_validate({"recordings": names, **told})


class ReplaysPage(Out):
    """Some replays."""

    replays: list[ReplayModel]
    next: str | None
    """The `before` of the next page; null on the last."""

    @classmethod
    def of(cls, views: list[ReplayView], *, more: bool) -> Self:
        return cls(
            replays=[ReplayModel.of(view) for view in views],
            next=next_of(views, lambda view: (view.row.ordered_at, view.row.id), more=more),
        )
