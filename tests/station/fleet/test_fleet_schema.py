"""Shows that the fleet's migrations make the tables of the code, beside whatever else is there."""

from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from newest_schema import make_store
from sqlalchemy import inspect, text

from station.errors import StationError, StoreUnusable
from station.fleet import EMPTY, ensure_ready, fleet_revision, migrate_fleet, migrating
from station.fleet.connecting import fleet_engine
from station.fleet.migrating import VERSION_TABLE
from station.fleet.tables import FleetTable
from station.store import Store, migrate, revision_of


def tables(url):
    engine = fleet_engine(url)
    found = set(inspect(engine).get_table_names())
    engine.dispose()
    return found


def differences(url):
    def ours(_thing, name, kind, *_):
        return kind != "table" or name.startswith("fleet_") and name != VERSION_TABLE

    engine = fleet_engine(url)
    with engine.connect() as connection:
        options = {"compare_type": True, "include_object": ours, "version_table": VERSION_TABLE}
        context = MigrationContext.configure(connection, opts=options)
        found = compare_metadata(context, FleetTable.metadata)
    engine.dispose()
    return found


def test_migrating_up_gives_exactly_the_tables_of_the_code_and_down_leaves_none(any_url):
    assert fleet_revision(any_url) is None
    migrate_fleet(any_url)
    assert differences(any_url) == []
    migrate_fleet(any_url, EMPTY)
    assert tables(any_url) == {VERSION_TABLE}
    migrate_fleet(any_url)
    migrate_fleet(any_url)
    assert differences(any_url) == []


def test_the_revisions_known_without_alembic_are_those_it_walks():
    config = Config()
    config.set_main_option("script_location", str(Path(migrating.__file__).with_name("migrations")))
    steps = ScriptDirectory.from_config(config).walk_revisions()
    assert [step.revision for step in steps][::-1] == migrating.known_revisions()


def test_the_tables_of_a_station_and_of_the_fleet_do_not_collide(any_url):
    make_store(any_url)
    migrate_fleet(any_url)
    assert differences(any_url) == []
    migrate(any_url)
    Store.open(any_url).close()
    migrate_fleet(any_url, EMPTY)
    assert revision_of(any_url) is not None


def test_a_database_of_a_newer_version_is_refused_by_name(any_url):
    migrate_fleet(any_url)
    engine = fleet_engine(any_url)
    with engine.begin() as connection:
        connection.execute(text(f"UPDATE {VERSION_TABLE} SET version_num = 'f9999'"))
    engine.dispose()
    for refused in (ensure_ready, migrate_fleet):
        with pytest.raises(StationError, match="f9999, this version knows up to f0002"):
            refused(any_url)


def test_a_database_that_is_not_there_is_said_in_a_line(tmp_path):
    with pytest.raises(StoreUnusable, match="cannot be used now"):
        ensure_ready(f"postgresql://nobody@/none?host={tmp_path}")
