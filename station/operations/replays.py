"""Having recordings measured once more, with calibrations that somebody chooses.

What was measured before stays: a measurement is known by recording, frame, calibration and
reference, so a replay adds what nobody had measured yet, and finds what somebody had.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from sqlalchemy.orm import Session

from station.errors import InputUnusable, StateConflict
from station.operations.collaborators import Station
from station.store import (
    Action,
    Actor,
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    Pass,
    PassState,
    Recording,
    Replay,
    RigCalibration,
    add_job,
    audit,
    recordings_of,
    the,
)
from station.store.measured import measured_by

ReferenceName = Literal["S1002", "LMA"]
_MEASURED = {PassState.DONE, PassState.RECOVERED}


@dataclass(frozen=True, slots=True)
class ReplayOrder:
    """What to measure once more, and with what."""

    recordings: Sequence[str] = ()
    pass_id: str | None = None
    """In place of recordings: all of its own."""
    calibrations: Mapping[str, str] | None = None
    """One a sensor."""
    rig_calibration: str | None = None
    """For sensors that are to be measured together."""
    reference: ReferenceName | None = None
    """None: the station's."""


@dataclass(frozen=True, slots=True)
class ReplayView:
    """A replay, the job that does it, and how many measurements it has come to."""

    row: Replay
    job: Job
    measurements: int


def order_replay(station: Station, order: ReplayOrder, *, by: Actor) -> ReplayView:
    """Put a replay into the worker's list.

    Raises
    ------
    NotFound
        If the station knows no such recording, pass or calibration.
    StateConflict
        If a recording still runs or was deleted, a calibration is not ready, or the pass is yet to
        be measured with the calibrations given, against the station's reference.
    InputUnusable
        If recordings and calibrations do not fit together.
    """
    now = station.now()
    replay_id, job_id = station.new_id(), station.new_id()
    with station.store.change() as session:
        known = session.get(Replay, replay_id)
        if known is not None:  # ordered by this call, before the API process died of it
            return replay_view(session, known)
        recordings = _recordings(session, order)
        chosen, rig = _calibrations(session, order, recordings)
        reference = order.reference or station.settings.reference
        _ensure_passes_come_first(session, station, recordings, chosen, reference)
        row = Replay(
            id=replay_id,
            ordered_at=now,
            ordered_by=by.name,
            job_id=job_id,
            pass_id=order.pass_id,
            steps={"steps": _steps(recordings, rig)},
            calibrations=chosen,
            rig_calibration_id=None if rig is None else rig.id,
            reference=reference,
            results={},
        )
        job = add_job(session, job_id, JobKind.REPLAY, replay_id, at=now)
        session.add(row)
        told = {"recordings": [each.id for each in recordings], "calibrations": chosen}
        audit(session, Action.ORDER, "replay", replay_id, by=by, at=now, after=told)
    station.jobs.submit(JobKind.REPLAY, job_id)
    return ReplayView(row, job, 0)


def replay_view(session: Session, row: Replay) -> ReplayView:
    """Return a replay with its job."""
    return ReplayView(row, the(session, Job, row.job_id), measured_by(session, row.id))


def _recordings(session: Session, order: ReplayOrder) -> list[Recording]:
    if (order.pass_id is None) == (not order.recordings):
        raise InputUnusable("give either recordings or a pass to measure once more, not both")
    if order.pass_id is None:
        twice = len(order.recordings) - len(set(order.recordings))
        if twice:
            raise InputUnusable(f"{twice} of the recordings are given twice; give each once")
        found = [the(session, Recording, name) for name in order.recordings]
    else:
        found = list(recordings_of(session, the(session, Pass, order.pass_id)))
    for each in found:
        _ensure_there(each)
    filled = [each for each in found if each.recorded]
    if not filled:
        raise InputUnusable("none of the recordings holds a frame; give one that does")
    return filled


def _ensure_there(recording: Recording) -> None:
    if recording.closed_at is None:
        raise StateConflict(
            f"recording {recording.id} still runs; finish it, then replay it", state="recording"
        )
    if recording.deleted_at is not None:
        raise StateConflict(
            f"recording {recording.id} was deleted on {recording.deleted_at:%Y-%m-%d} "
            f"({recording.deleted_why}); what was measured from it is in /v1/measurements",
            state="deleted",
        )


def _calibrations(
    session: Session, order: ReplayOrder, recordings: Sequence[Recording]
) -> tuple[dict[str, str], RigCalibration | None]:
    """Return the calibration of each sensor, and that of the rig where one is given."""
    sensors = sorted({each.sensor for each in recordings})
    given = order.calibrations or {}
    for sensor, calibration_id in given.items():
        if sensor not in sensors:
            raise InputUnusable(
                f"a calibration for sensor {sensor}, of which no recording is given; "
                f"the recordings are of {', '.join(sensors)}"
            )
        _ensure_fits(session, sensor, calibration_id)
    rig = None if order.rig_calibration is None else _rig(session, order.rig_calibration)
    chosen: dict[str, str] = {}
    for sensor in sensors:
        own = [each for each in recordings if each.sensor == sensor]
        name = given.get(sensor) or (None if rig is None else _under_rig(rig, sensor, own))
        if name is None:
            raise InputUnusable(
                f"no calibration for sensor {sensor}; give one a sensor in `calibrations`, "
                "or the calibration of their rig"
            )
        chosen[sensor] = name
    return chosen, rig


def _ensure_fits(session: Session, sensor: str, calibration_id: str) -> None:
    row = the(session, Calibration, calibration_id)
    _ensure_ready(f"calibration {row.id}", row.state)
    if row.sensor != sensor:
        raise InputUnusable(
            f"calibration {row.id} is of sensor {row.sensor}, not of {sensor}; "
            "give one of the same sensor"
        )


def _rig(session: Session, calibration_id: str) -> RigCalibration:
    row = the(session, RigCalibration, calibration_id)
    _ensure_ready(f"calibration {row.id} of a rig", row.state)
    return row


def _ensure_ready(what: str, state: CalibrationState) -> None:
    if state is not CalibrationState.READY:
        raise StateConflict(f"{what} is {state}; only a ready one can measure", state=state)


def _under_rig(rig: RigCalibration, sensor: str, recordings: Sequence[Recording]) -> str | None:
    """Return what a rig's sensor is measured with: as it was recorded, else as the rig was solved.

    So a pass is measured with its own rig as it was when the train went by.
    """
    names = {each["sensor"] for each in json.loads(rig.document or "{}").get("sensors", [])}
    if sensor not in names:
        raise InputUnusable(
            f"recordings of sensor {sensor}, which is not in rig {rig.rig} as calibration {rig.id} "
            f"has it; it has {', '.join(sorted(names))}"
        )
    recorded = {each.calibration_id for each in recordings if each.calibration_id is not None}
    if len(recorded) > 1:
        raise InputUnusable(
            f"recordings of sensor {sensor} were made under {len(recorded)} calibrations; "
            "give the one to measure with in `calibrations`"
        )
    solved: Mapping[str, str] = (rig.ordered or {}).get("calibrations", {})
    return recorded.pop() if recorded else solved.get(sensor)


def _ensure_passes_come_first(
    session: Session,
    station: Station,
    recordings: Sequence[Recording],
    chosen: Mapping[str, str],
    reference: str,
) -> None:
    """Let a pass have its own readings before others stand beside them."""
    if reference == station.settings.reference:
        return
    for each in recordings:
        if each.pass_id is None or each.calibration_id != chosen[each.sensor]:
            continue
        row = the(session, Pass, each.pass_id)
        if row.state not in _MEASURED:
            raise StateConflict(
                f"pass {row.id} is {row.state}, its wheels are not measured against "
                f"{station.settings.reference} yet; replay it against that first",
                state=row.state,
            )


def _steps(recordings: Sequence[Recording], rig: RigCalibration | None) -> list[list[str]]:
    """Return what is measured together: each recording by itself, or a pass's on its rig."""
    if rig is None:
        return [[each.id] for each in recordings]
    together: dict[str | None, list[Recording]] = {}
    for each in recordings:
        together.setdefault(each.pass_id, []).append(each)
    for group in together.values():
        if len({each.sensor for each in group}) < len(group):
            raise InputUnusable(
                "two recordings of one sensor are to be measured together on a rig; give one a "
                "sensor, and replay the others by a call of their own"
            )
    return [[each.id for each in group] for group in together.values()]
