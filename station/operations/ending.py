"""The end of a pass, whoever ended it: closed, accounted for, given to the worker.

First it is written down who ended it, then the recordings are closed: a station that dies between
the two finds what it was at, and goes on with it.
"""

from collections.abc import Mapping

from sqlalchemy.orm import Session

from station.operations.closing import Closed, close_all, note
from station.operations.collaborators import Station
from station.operations.views import PassView, view_of
from station.store import (
    HELD,
    PASS,
    STATION,
    Action,
    EndedBy,
    JobKind,
    Pass,
    PassState,
    add_job,
    audit,
    recordings_of,
    the,
)
from station.trains import keep_axles


def step(row: Pass, wanted: PassState) -> None:
    """Let a pass go on into its next state.

    Raises
    ------
    StateConflict
        If the present state does not lead there.
    """
    PASS.check(row.id, row.state, wanted)
    row.state = wanted


def note_own_end(station: Station, pass_id: str, ended_by: EndedBy, why: str) -> bool:
    """Write down that the station itself ends a pass; False where somebody else has."""
    with station.store.change() as session:
        row = the(session, Pass, pass_id)
        if row.state not in HELD or row.ended_by is not None:
            return False
        row.ended_by, row.ended_why = ended_by, why
        told = {"ended_by": ended_by.value, "why": why}
        audit(session, Action.FINISH, "pass", pass_id, by=STATION, at=station.now(), after=told)
        return True


def end_pass(station: Station, pass_id: str) -> PassView:
    """Close the recordings of a pass, hold them against what was counted, have them measured."""
    with station.store.look() as session:
        view = view_of(session, pass_id)
    expected = {recording.sensor: recording.expected for recording in view.recordings}
    accounts = close_all(station, view.recordings, expected)
    with station.store.change() as session:
        row = the(session, Pass, pass_id)
        _note_accounts(station, session, row, accounts)
        step(row, PassState.RECORDED)
        _decide_next(station, session, row)
        closed = view_of(session, pass_id)
    if row.job_id is not None:
        station.jobs.submit(JobKind.MEASURE, row.job_id)
    return closed


def fail_pass(station: Station, view: PassView, reason: str) -> None:
    """End a pass that did not come to be recorded; what some sensors recorded stays."""
    accounts = close_all(station, view.recordings, {})
    with station.store.change() as session:
        row = the(session, Pass, view.row.id)
        _note_accounts(station, session, row, accounts)
        step(row, PassState.FAILED)
        row.reason = reason


def _note_accounts(
    station: Station, session: Session, row: Pass, accounts: Mapping[str, Closed]
) -> None:
    row.finished_at = station.now()
    for recording in recordings_of(session, row):
        recording.closed_at = row.finished_at
        note(recording, accounts[recording.id], recording.expected)


def _decide_next(station: Station, session: Session, row: Pass) -> None:
    recordings = recordings_of(session, row)
    filled = [recording for recording in recordings if recording.recorded]
    if not filled and all(recording.expected == 0 for recording in recordings):
        step(row, PassState.DONE)
        row.reason = "no wheel went by"
    elif not filled:
        step(row, PassState.FAILED)
        row.reason = "no frame was recorded: " + "; ".join(
            f"{recording.sensor}: {recording.summary}" for recording in recordings
        )
    elif all(recording.calibration_id is None for recording in filled):
        row.reason = "not measured: no sensor had an active calibration when it was recorded"
    else:
        _have_measured(station, session, row)
        return
    # Nothing more will be measured of it; what the controller counted are rows all the same.
    keep_axles(session, row, station.settings)


def _have_measured(station: Station, session: Session, row: Pass) -> None:
    job = add_job(session, station.new_id(), JobKind.MEASURE, row.id, at=station.now())
    step(row, PassState.MEASURING)
    row.job_id = job.id
