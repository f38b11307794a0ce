"""Shows that a wheel is kept once for each reference it was measured against, that the first is its
pass's, and that no older store is filled with what it cannot hold."""

from datetime import UTC, datetime

import pytest
from sqlalchemy import func, select

from station.errors import StationError
from station.store import (
    Calibration,
    CalibrationState,
    JobKind,
    Measurement,
    Pass,
    PassState,
    Recording,
    Replay,
    ReplayMeasurement,
    Store,
    add_job,
    migrate,
    the,
)
from station.store.lists import measurements_page
from station.store.measured import (
    add_measurements,
    measured_by,
    note_measured,
    recordings_replayed,
    wheels_of,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def a_wheel(reference="S1002", frame=1, calibration="c1"):
    return Measurement(
        recording_id="r1",
        frame=frame,
        calibration_id=calibration,
        sensor="left",
        pass_id="p1",
        reference=reference,
        software="none",
        measured_at=NOON,
        wheel={"profile": {"d_mm": [0.0]}},
    )


def fill(session):
    session.add(Pass(id="p1", state=PassState.DONE, opened_at=NOON))
    session.add(
        Calibration(
            id="c1",
            state=CalibrationState.READY,
            sensor="left",
            target="dots:7x8:12",
            method="joint",
            recording_ids={"recordings": [], "laser_off": []},
            created_at=NOON,
            job_id="j",
        )
    )
    session.flush()
    session.add(
        Recording(
            id="r1",
            sensor="left",
            pass_id="p1",
            path="x",
            opened_at=NOON,
            recovered=False,
            calibration_id="c1",
        )
    )
    session.flush()


def a_replay(session, name="replay1"):
    add_job(session, f"job-{name}", JobKind.REPLAY, name, at=NOON)
    session.add(
        Replay(
            id=name,
            ordered_at=NOON,
            ordered_by="test",
            job_id=f"job-{name}",
            steps={"steps": [["r1"]]},
            calibrations={"left": "c1"},
            reference="LMA",
            results={},
        )
    )
    session.flush()


def test_another_reference_is_another_measurement_and_the_first_is_of_the_pass(store):
    with store.change() as session:
        fill(session)
        assert add_measurements(session, [a_wheel()]) == 1
        assert add_measurements(session, [a_wheel("LMA"), a_wheel("LMA", frame=2)]) == 2
        assert add_measurements(session, [a_wheel(), a_wheel("LMA")]) == 0
    with store.look() as session:
        assert len(measurements_page(session, limit=9).rows) == 3
        own = wheels_of(session, the(session, Pass, "p1"))
    assert [(row.frame, row.reference) for row in own] == [(1, "S1002"), (2, "LMA")]


def test_a_replay_names_what_it_made_and_what_it_found_once(store):
    with store.change() as session:
        fill(session)
        a_replay(session)
        add_measurements(session, [a_wheel()])
        for _ in range(2):
            again = [a_wheel(), a_wheel(frame=2)]
            add_measurements(session, again)
            note_measured(session, "replay1", again)
            session.flush()
        assert measured_by(session, "replay1") == 2
        assert recordings_replayed(session) == {"r1"}
    with store.look() as session:
        assert len(measurements_page(session, limit=9, replay="replay1").rows) == 2
        assert measurements_page(session, limit=9, replay="another").rows == []


def test_going_back_loses_no_measurement_against_another_reference_unsaid(any_url):
    migrate(any_url)
    store = Store.open(any_url)
    with store.change() as session:
        fill(session)
        a_replay(session)
        both = [a_wheel(), a_wheel("LMA")]
        add_measurements(session, both)
        note_measured(session, "replay1", both)
    store.close()
    with pytest.raises(StationError, match="against several references"):
        migrate(any_url, "0010")
    migrate(any_url, "0010", losing=True)
    migrate(any_url)
    store = Store.open(any_url)
    with store.look() as session:
        assert [row.reference for row in measurements_page(session, limit=9).rows] == ["S1002"]
        assert session.scalar(select(func.count()).select_from(ReplayMeasurement)) == 0
    store.close()
