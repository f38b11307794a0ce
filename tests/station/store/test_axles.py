"""Shows that axles are kept once, wheelsets are followed in the order of passing, and that the
tables of axles come and go without touching what was there, on SQLite and on PostgreSQL."""

from datetime import UTC, datetime, timedelta

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from newest_schema import make_store
from sqlalchemy import inspect, text

from measure import Placing, Side
from station.store import (
    AxleWheel,
    Calibration,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    Recording,
    Store,
    Table,
    migrate,
    revision_of,
)
from station.store.connecting import open_engine
from station.store.lists import measurements_page
from station.store.measured import axles_of, history_of, places_of, replace_axles

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


@pytest.fixture
def any_store(any_url):
    make_store(any_url)
    store = Store.open(any_url)
    with store.change() as session:
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
    yield store
    store.close()


def a_measurement(row, *, frame):
    return Measurement(
        recording_id=row.id,
        frame=frame,
        calibration_id="c1",
        sensor="left",
        pass_id=row.id,
        reference="S1002",
        software="treadline 0",
        measured_at=row.opened_at,
        wheel={"frame": frame},
        regime="tsi",
    )


def a_pass(session, name, day):
    """A pass with one measured wheel."""
    row = Pass(id=name, state=PassState.DONE, opened_at=NOON + timedelta(days=day), axles=1)
    session.add(row)
    session.flush()
    opened = {"path": "x", "opened_at": row.opened_at, "recovered": False}
    session.add(Recording(id=name, sensor="left", pass_id=name, calibration_id="c1", **opened))
    session.flush()
    measurement = a_measurement(row, frame=1)
    session.add(measurement)
    session.flush()
    return row, measurement


def an_axle(row, measurement=None, *, side=Side.LEFT, placing=Placing.CERTAIN, others=()):
    return AxleWheel(
        pass_id=row.id,
        place=1,
        side=side,
        number=1,
        placing=placing,
        measurement_id=None if measurement is None else measurement.id,
        others={"measurements": list(others)},
        reason=None if measurement is not None else "not seen",
        wheelset="w1",
        wheelset_side=side,
        jumps={},
    )


def test_axles_worked_out_again_take_the_place_of_the_first(any_store):
    with any_store.change() as session:
        row, measurement = a_pass(session, "p1", 0)
        for _ in range(2):
            rows = [an_axle(row, measurement), an_axle(row, side=Side.RIGHT)]
            replace_axles(session, row.id, rows)
    with any_store.look() as session:
        kept = axles_of(session, "p1")
    assert [(each.side, each.measurement_id is None) for each in kept] == [
        (Side.LEFT, False),
        (Side.RIGHT, True),
    ]


def test_a_wheelset_is_followed_in_the_order_of_passing(any_store):
    with any_store.change() as session:
        for name, day in (("p3", 3), ("p1", 1), ("p2", 2)):
            row, measurement = a_pass(session, name, day)
            placing = Placing.INFERRED if name == "p2" else Placing.CERTAIN
            replace_axles(session, name, [an_axle(row, measurement, placing=placing)])
    with any_store.look() as session:
        found = history_of(session, "w1", side=Side.LEFT)
        assert [each.pass_id for each in found] == ["p1", "p3"]
        last = session.get(Pass, "p3")
        assert [each.pass_id for each in history_of(session, "w1", before=last)] == ["p1"]
        assert [each.pass_id for each in history_of(session, "w1", most=1)] == ["p3"]
        assert history_of(session, "w1", side=Side.RIGHT) == []


def test_measurements_are_found_by_wheelset_and_side_each_with_its_place(any_store):
    with any_store.change() as session:
        row, measurement = a_pass(session, "p1", 0)
        once_more = a_measurement(row, frame=2)
        session.add(once_more)
        session.flush()
        replace_axles(session, row.id, [an_axle(row, measurement, others=[once_more.id])])
        a_pass(session, "p2", 1)
    with any_store.look() as session:
        page = measurements_page(session, limit=9, wheelset="w1", side=Side.LEFT)
        assert [each.pass_id for each in page.rows] == ["p1"]
        assert measurements_page(session, limit=9, side=Side.RIGHT).rows == []
        every = measurements_page(session, limit=9).rows
        places = places_of(session, every)
        assert [places[each.id].wheelset for each in every[:2]] == ["w1", "w1"]
        assert len(every) == len(places) + 1
        assert places_of(session, []) == {}


def differences(url):
    engine = open_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        found = compare_metadata(context, Table.metadata)
    engine.dispose()
    return found


def test_axles_come_and_go_and_leave_what_was_there(any_url):
    migrate(any_url, "0002")
    engine = open_engine(any_url)
    with engine.begin() as connection:
        connection.execute(
            text("INSERT INTO passes (id, state, opened_at) VALUES ('old', 'done', :at)"),
            {"at": "2026-07-01 12:00:00+00:00"},
        )
    migrate(any_url)
    assert differences(any_url) == []
    store = Store.open(any_url)
    with store.look() as session:
        old = session.get(Pass, "old")
        assert (old.axles, old.consist, axles_of(session, "old")) == (None, None, [])
    store.close()
    migrate(any_url, "0002")
    assert revision_of(any_url) == "0002"
    assert "axle_wheels" not in inspect(engine).get_table_names()
    with engine.connect() as connection:
        assert connection.execute(text("SELECT id FROM passes")).all() == [("old",)]
    engine.dispose()
