"""The rows of a pass that begins: for the first time, or once more as its sensors did not arm."""

from sqlalchemy.orm import Session

from station.errors import StateConflict
from station.operations.arming import calibration_in_force, rig_in_force
from station.operations.collaborators import Station
from station.operations.ending import step
from station.operations.views import PassView
from station.recording import left_behind
from station.store import Pass, PassState, Recording, recordings_of
from station.trains import Consist


def may_begin_again(view: PassView) -> bool:
    """Tell whether a pass has failed before anything was recorded, and nobody has ended it.

    A controller that tries a call again whose answer was 503 means the same train.
    """
    row = view.row
    never_began = row.state is PassState.FAILED and row.ended_by is None
    return never_began and not any(each.recorded for each in view.recordings)


def begin_pass(
    station: Station, session: Session, pass_id: str, train: str | None, consist: Consist | None
) -> PassView:
    """Put the rows of a pass into the store, new where it begins again.

    Raises
    ------
    StateConflict
        If it is there already and not to begin again.
    """
    row = session.get(Pass, pass_id)
    if row is None:
        row = Pass(
            id=pass_id,
            state=PassState.ARMED,
            train=train,
            opened_at=station.now(),
            consist=None if consist is None else consist.to_json(),
        )
        session.add(row)
    else:
        _set_back(station, session, row)
    recordings = _recordings(station, session, row)
    session.add_all(recordings)
    return PassView(row, recordings)


def clear_empty(station: Station, recording: Recording) -> None:
    """Take away files without a frame, which a try to arm has left; without any there is nothing.

    Raises
    ------
    StateConflict
        If there is a frame in them.
    """
    path = station.layout.root / recording.path
    capture = station.captures[recording.sensor]
    if capture.status().session_id == recording.pass_id:
        capture.finish()  # it had not heard that the pass had failed
    found = station.salvage(path)
    if found is None:
        return
    if found.frames:
        raise StateConflict(
            f"{recording.path} has {found.frames} frames of a pass that was not armed; open a new "
            "one under a new id",
            state=PassState.FAILED,
        )
    for _, part in left_behind(path):
        part.unlink(missing_ok=True)


def _set_back(station: Station, session: Session, row: Pass) -> None:
    step(row, PassState.ARMED)
    row.opened_at, row.finished_at, row.reason = station.now(), None, None
    for each in recordings_of(session, row):
        session.delete(each)
    session.flush()  # the new ones have their names


def _recordings(station: Station, session: Session, row: Pass) -> list[Recording]:
    return [
        Recording(
            # With "pass." before it, as a calibration session may bear the same name.
            id=f"pass.{row.id}.{sensor.id}",
            sensor=sensor.id,
            pass_id=row.id,
            path=str(station.layout.pass_recording(row.id, sensor.id)),
            opened_at=row.opened_at,
            calibration_id=calibration_in_force(session, sensor.id),
            rig_calibration_id=rig_in_force(session, station.settings, sensor.id),
            recovered=False,
        )
        for sensor in station.sensors
    ]
