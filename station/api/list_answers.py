"""What comes out over HTTP of lists: some rows, and `next`, the `before` of the next page."""

from collections.abc import Mapping, Sequence
from typing import Self

from station.api.answers import (
    CalibrationModel,
    JobModel,
    Out,
    PassModel,
    RecordingModel,
    RigActivationModel,
    RigCalibrationModel,
    SessionModel,
)
from station.api.paging import next_of
from station.operations import PassView, SessionView
from station.store import (
    Calibration,
    CalibrationSession,
    Job,
    Pass,
    Recording,
    RigActivation,
    RigCalibration,
)
from station.store.lists import Page


class _PageModel(Out):
    next: str | None
    """The `before` of the next page; null on the last."""


class PassesPage(_PageModel):
    """Some passes."""

    passes: list[PassModel]

    @classmethod
    def of(cls, page: Page[Pass], recordings: Mapping[str, Sequence[Recording]]) -> Self:
        views = [PassView(row, recordings.get(row.id, ())) for row in page.rows]
        return cls(
            passes=[PassModel.of(view) for view in views],
            next=next_of(page.rows, lambda row: (row.opened_at, row.id), more=page.more),
        )


class SessionsPage(_PageModel):
    """Some calibration sessions."""

    sessions: list[SessionModel]

    @classmethod
    def of(
        cls, page: Page[CalibrationSession], recordings: Mapping[str, Sequence[Recording]]
    ) -> Self:
        views = [SessionView(row, recordings.get(row.id, ())) for row in page.rows]
        return cls(
            sessions=[SessionModel.of(view) for view in views],
            next=next_of(page.rows, lambda row: (row.opened_at, row.id), more=page.more),
        )


class RecordingsPage(_PageModel):
    """Some recordings."""

    recordings: list[RecordingModel]

    @classmethod
    def of(cls, page: Page[Recording]) -> Self:
        return cls(
            recordings=[RecordingModel.of(row) for row in page.rows],
            next=next_of(page.rows, lambda row: (row.opened_at, row.id), more=page.more),
        )


class JobsPage(_PageModel):
    """Some jobs."""

    jobs: list[JobModel]

    @classmethod
    def of(cls, page: Page[Job]) -> Self:
        return cls(
            jobs=[JobModel.of(row) for row in page.rows],
            next=next_of(page.rows, lambda row: (row.created_at, row.id), more=page.more),
        )


class CalibrationsPage(_PageModel):
    """Some calibrations of sensors, without their documents."""

    calibrations: list[CalibrationModel]

    @classmethod
    def of(cls, page: Page[Calibration]) -> Self:
        return cls(
            calibrations=[CalibrationModel.of(row, None) for row in page.rows],
            next=next_of(page.rows, lambda row: (row.created_at, row.id), more=page.more),
        )


class RigCalibrationsPage(_PageModel):
    """Some calibrations of rigs, without their documents."""

    calibrations: list[RigCalibrationModel]

    @classmethod
    def of(cls, page: Page[RigCalibration]) -> Self:
        return cls(
            calibrations=[RigCalibrationModel.of(row, None) for row in page.rows],
            next=next_of(page.rows, lambda row: (row.created_at, row.id), more=page.more),
        )


class RigInForcePage(Out):
    """Some of a rig's calibrations, the last one first."""

    rig: str
    calibrations: list[RigActivationModel]
    next: int | None
    """The `before` of the next page; null on the last."""

    @classmethod
    def of(cls, rig: str, page: Page[RigActivation]) -> Self:
        return cls(
            rig=rig,
            calibrations=[RigActivationModel.of(row) for row in page.rows],
            next=page.rows[-1].version if page.more else None,
        )
