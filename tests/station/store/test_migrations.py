"""Shows that the migrations make the tables of the code, and take them away again."""

import json
from datetime import UTC, datetime

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import inspect, text

from station.bench.service.filled_store import Traffic, fill
from station.errors import StationError
from station.progress import silent
from station.store import EMPTY, Action, Actor, Store, Table, audit, migrate, revision_of
from station.store.connecting import open_engine
from station.store.lists import measurements_page
from station.store.measured import profiles_of


def differences(url):
    engine = open_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        found = compare_metadata(context, Table.metadata)
    engine.dispose()
    return found


def test_migrating_up_gives_exactly_the_tables_of_the_code(any_url):
    assert revision_of(any_url) is None
    migrate(any_url)
    assert revision_of(any_url) is not None
    assert differences(any_url) == []


def test_migrating_down_leaves_nothing_and_up_again_all(any_url):
    migrate(any_url)
    migrate(any_url, EMPTY)
    engine = open_engine(any_url)
    assert inspect(engine).get_table_names() == ["alembic_version"]
    engine.dispose()
    migrate(any_url)
    assert differences(any_url) == []


def test_migrating_twice_changes_nothing(any_url):
    migrate(any_url)
    before = revision_of(any_url)
    migrate(any_url)
    assert revision_of(any_url) == before


def test_going_back_before_rigs_keeps_what_was_measured(any_url):
    migrate(any_url, "0003")
    at = "2026-07-01 12:00:00"
    statements = [
        f"INSERT INTO passes (id, state, opened_at) VALUES ('p', 'done', '{at}')",
        "INSERT INTO calibrations (id, state, sensor, target, method, recording_ids, created_at,"
        f" job_id) VALUES ('c', 'ready', 'inner', 'dots:7x8:12', 'joint', '{{}}', '{at}', 'j')",
        "INSERT INTO recordings (id, sensor, pass_id, path, opened_at, recovered) VALUES"
        f" ('r', 'inner', 'p', 'r.mcap', '{at}', false)",
        "INSERT INTO measurements (recording_id, frame, calibration_id, sensor, reference,"
        " software, measured_at, wheel) VALUES"
        f" ('r', 1, 'c', 'inner', 'S1002', '-', '{at}', '{{}}')",
        "INSERT INTO calibration_sessions (id, state, sensor, target, pictures, opened_at) VALUES"
        f" ('of-a-sensor', 'recorded', 'inner', 'dots:7x8:12', 3, '{at}')",
    ]
    _execute(any_url, statements)
    migrate(any_url)
    _execute(
        any_url,
        [
            "INSERT INTO rig_calibrations (id, state, rig, created_at) VALUES"
            f" ('g', 'ready', 'w', '{at}')",
            "UPDATE recordings SET rig_calibration_id = 'g'",
            "UPDATE measurements SET rig_calibration_id = 'g'",
            "INSERT INTO calibration_sessions (id, state, rig, target, pictures, opened_at) VALUES"
            f" ('of-a-rig', 'recorded', 'w', 'dots:7x8:12', 3, '{at}')",
            "INSERT INTO recordings (id, sensor, session_id, path, opened_at, recovered) VALUES"
            f" ('s', 'inner', 'of-a-rig', 's.mcap', '{at}', false)",
        ],
    )
    migrate(any_url, "0003")
    assert _values(any_url, "SELECT recording_id, frame FROM measurements") == [("r", 1)]
    assert _values(any_url, "SELECT id FROM calibration_sessions") == [("of-a-sensor",)]
    migrate(any_url)
    assert _values(any_url, "SELECT rig_calibration_id FROM measurements") == [(None,)]
    assert differences(any_url) == []


def test_going_back_loses_no_measurement_by_another_calibration_of_a_rig_unsaid(any_url):
    migrate(any_url)
    rigs = [
        f"INSERT INTO rig_calibrations (id, state, rig, created_at) VALUES ('{name}', 'ready',"
        f" 'w', '{AT}')"
        for name in "gh"
    ]
    measured = [
        "INSERT INTO measurements (recording_id, frame, calibration_id, rig_calibration_id, sensor,"
        f" reference, software, measured_at, wheel) VALUES ('r', 1, 'c', '{rig}', 'w', 'S1002',"
        f" '-', '{AT}', '{{}}')"
        for rig in "gh"
    ]
    _execute(any_url, [*MEASURED[:2], *rigs, *measured])
    with pytest.raises(StationError, match="several calibrations of their rig"):
        migrate(any_url, "0008")
    assert _values(any_url, "SELECT count(*) FROM measurements") == [(2,)]
    migrate(any_url, "0008", losing=True)
    assert _values(any_url, "SELECT rig_calibration_id FROM measurements") == [("h",)]


def test_every_step_back_and_forth_works_with_rows_in_every_table_of_trains(any_url):
    migrate(any_url)
    store = Store.open(any_url)
    fill(store, Traffic(passes=2, axles=3), silent)
    store.close()
    revision = revision_of(any_url)
    while revision is not None and revision > "0001":
        revision = f"{int(revision) - 1:04}"
        migrate(any_url, revision)
        assert revision_of(any_url) == revision
    assert _values(any_url, "SELECT count(*) FROM measurements") == [(12,)]
    migrate(any_url)
    assert _values(any_url, "SELECT count(*) FROM measurement_profiles") == [(12,)]
    assert differences(any_url) == []
    migrate(any_url, EMPTY)
    assert revision_of(any_url) is None


AT = "2026-07-01 12:00:00"
MEASURED = [
    "INSERT INTO calibrations (id, state, sensor, target, method, recording_ids, created_at,"
    f" job_id) VALUES ('c', 'ready', 'left', 'dots:7x8:12', 'joint', '{{}}', '{AT}', 'j')",
    "INSERT INTO recordings (id, sensor, path, opened_at, recovered) VALUES"
    f" ('r', 'left', 'r.mcap', '{AT}', false)",
    "INSERT INTO measurements (recording_id, frame, calibration_id, sensor, reference, software,"
    f" measured_at, wheel) VALUES ('r', 1, 'c', 'left', 'S1002', '-', '{AT}', :wheel)",
]
WHEEL = {
    "frame": 1,
    "flange_height": {"value": 28.000000000000004, "u95": 1e-05},
    "profile": {"d_mm": [0.1, 70.0], "h_mm": [-0.0, 1e-07]},
    "quality": {"points": 2},
}


@pytest.mark.parametrize("wheel", [WHEEL, WHEEL | {"profile": None, "reason": "dark"}])
def test_profiles_move_into_a_table_of_their_own_and_back_unchanged(any_url, wheel):
    migrate(any_url, "0004")
    _execute(any_url, MEASURED[:2])
    _execute(any_url, MEASURED[2:], wheel=json.dumps(wheel))
    migrate(any_url)
    store = Store.open(any_url)
    with store.look() as session:
        (row,) = measurements_page(session, limit=9).rows
        kept = profiles_of(session, [row])
    store.close()
    profile = wheel["profile"]
    assert row.wheel == {name: value for name, value in wheel.items() if name != "profile"}
    assert kept == ({} if profile is None else {row.id: profile})
    migrate(any_url, "0004")
    ((back,),) = _values(any_url, "SELECT wheel FROM measurements")
    found = json.loads(back) if isinstance(back, str) else back
    assert found == {name: value for name, value in wheel.items() if value is not None}


def test_going_back_before_the_audit_trail_needs_to_be_told_that_it_may_be_lost(any_url):
    migrate(any_url)
    store = Store.open(any_url)
    with store.change() as session:
        at = datetime(2026, 7, 1, tzinfo=UTC)
        audit(session, Action.CANCEL, "job", "j1", by=Actor("plc"), at=at)
    store.close()
    newest = revision_of(any_url)
    with pytest.raises(StationError, match="audit trail, 1 entries"):
        migrate(any_url, "0004")
    assert revision_of(any_url) == newest
    migrate(any_url, "0004", losing=True)
    migrate(any_url)
    assert _values(any_url, "SELECT count(*) FROM audit_entries") == [(0,)]


def test_a_store_of_a_newer_version_is_refused_in_one_line(any_url):
    migrate(any_url)
    _execute(any_url, ["UPDATE alembic_version SET version_num = '9999'"])
    with pytest.raises(StationError, match="at revision 9999, this version knows up to 0"):
        migrate(any_url)


def _execute(url, statements, **values):
    engine = open_engine(url)
    with engine.begin() as connection:
        for statement in statements:
            connection.execute(text(statement), values)
    engine.dispose()


def _values(url, statement):
    engine = open_engine(url)
    with engine.begin() as connection:
        rows = [tuple(row) for row in connection.execute(text(statement))]
    engine.dispose()
    return rows
