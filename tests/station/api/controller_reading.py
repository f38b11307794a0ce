"""Takes over into the model what the store has of passes, sessions, orders and jobs."""

from controller_calls import settle
from controller_model import KnownOrder, KnownPass, KnownSession

from station.store import (
    Activation,
    Calibration,
    CalibrationSession,
    Job,
    Pass,
    Recalibration,
    recordings_of,
)
from station.trains import Named


def read_all(served, model, *, foreseen=True):
    """Take over what the store has; where all was foreseen it has nothing else."""
    settle(served)
    with served.store.look() as session:
        _read_passes(session, model, foreseen=foreseen)
        _read_sessions(session, model, foreseen=foreseen)
        _read_orders(session, model)
        model.jobs = {row.id: row.state.value for row in session.query(Job)}
        versions = session.query(Activation).order_by(Activation.version)
        model.in_force = {row.sensor: row.version for row in versions}


def _read_passes(session, model, *, foreseen):
    rows = {row.id: row for row in session.query(Pass)}
    if foreseen:
        found = {name: row.state.value for name, row in rows.items()}
        expected = {name: known.state for name, known in model.passes.items()}
        assert found == expected, (found, expected)
    model.passes = {}
    for name, row in rows.items():
        consist = row.consist or {}
        wheelsets = [each["wheelset"] for each in consist.get("wheelsets", [])] or None
        recordings = recordings_of(session, row)
        calibrated = [each.sensor for each in recordings if each.calibration_id]
        model.passes[name] = KnownPass(
            train=row.train,
            consist=wheelsets,
            named_coming=consist.get("named") == Named.COMING,
            state=row.state.value,
            calibrated=tuple(calibrated),
            job=row.job_id,
            axles=row.axles,
            ended=row.ended_by is not None,
            blank=not any(each.recorded for each in recordings),
        )


def _read_sessions(session, model, *, foreseen):
    rows = {row.id: row for row in session.query(CalibrationSession)}
    if foreseen:
        found = {name: (row.state.value, row.pictures) for name, row in rows.items()}
        expected = {name: (known.state, known.pictures) for name, known in model.sessions.items()}
        assert found == expected, (found, expected)
    model.sessions = {
        name: KnownSession(
            row.sensor, row.target, row.state.value, row.pictures, row.ended_by is not None
        )
        for name, row in rows.items()
    }


def _read_orders(session, model):
    model.calibrations, model.recalibrations = (
        {row.id: KnownOrder(row.sensor, row.job_id, row.state.value) for row in rows}
        for rows in (session.query(Calibration), session.query(Recalibration))
    )
