"""Shows that the migrations make the tables of the code, and take them away again, on SQLite."""

from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import inspect

from station.store import EMPTY, Table, migrate, revision_of
from station.store.engine import open_engine


def differences(url):
    engine = open_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        found = compare_metadata(context, Table.metadata)
    engine.dispose()
    return found


def test_migrating_up_gives_exactly_the_tables_of_the_code(url):
    assert revision_of(url) is None
    migrate(url)
    assert revision_of(url) is not None
    assert differences(url) == []


def test_migrating_down_leaves_nothing_and_up_again_all(url):
    migrate(url)
    migrate(url, EMPTY)
    engine = open_engine(url)
    assert inspect(engine).get_table_names() == ["alembic_version"]
    engine.dispose()
    migrate(url)
    assert differences(url) == []


def test_migrating_twice_changes_nothing(url):
    migrate(url)
    before = revision_of(url)
    migrate(url)
    assert revision_of(url) == before
