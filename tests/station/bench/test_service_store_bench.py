"""Shows that the bench of the store asks real questions of a filled store, that they are answered
by indexes, and that neither trends nor lists read a profile.  How long it takes with a million
wheels is what the bench itself is for."""

import re

import pytest
from newest_schema import make_store
from sqlalchemy import event

from measure import Limits, Side
from station.bench.service.filled_store import Traffic, fill
from station.bench.service.store import bench_service_store
from station.progress import silent
from station.store import Store
from station.store.lists import measurements_page
from station.store.measured import places_of, profiles_of
from station.trains import wheelset_trend

TRAFFIC = Traffic(passes=6, axles=5, trains=2)


@pytest.fixture
def filled(any_url):
    make_store(any_url)
    store = Store.open(any_url)
    fill(store, TRAFFIC, silent)
    yield store
    store.close()


@pytest.fixture
def asked(filled):
    """Run a question; return the statements and parameters that went to the database."""

    def ask(question):
        found = []

        def note(_connection, _cursor, statement, parameters, *_):
            found.append((statement, parameters))

        event.listen(filled._engine, "before_cursor_execute", note)
        with filled.look() as session:
            question(session)
        event.remove(filled._engine, "before_cursor_execute", note)
        return [each for each in found if each[0].startswith("SELECT")]

    return ask


def a_trend(session):
    return wheelset_trend(session, TRAFFIC.wheelset(0, 3), Limits.default(), most=100)


def a_list(**of_which):
    def ask(session):
        return places_of(session, measurements_page(session, limit=10, **of_which).rows)

    return ask


QUESTIONS = {
    "trend": a_trend,
    "of a wheelset": a_list(wheelset=TRAFFIC.wheelset(0, 3)),
    "of a wheelset's side": a_list(wheelset=TRAFFIC.wheelset(0, 3), side=Side.LEFT),
    "of a side": a_list(side=Side.LEFT, after=20),
    "of a pass": a_list(pass_id="p000001"),
    "of a sensor": a_list(sensor="left", after=20),
    "of all": a_list(after=20),
}


def test_the_store_is_filled_as_said(filled):
    with filled.look() as session:
        rows = measurements_page(session, limit=1000).rows
        trend = a_trend(session)
        assert len(rows) == TRAFFIC.measurements == len(profiles_of(session, rows))
    assert [(side.side, side.passes) for side in trend.sides] == [(Side.LEFT, 3), (Side.RIGHT, 3)]


@pytest.mark.parametrize("question", QUESTIONS)
def test_no_question_reads_a_profile(asked, question):
    statements = [statement for statement, _ in asked(QUESTIONS[question])]
    assert statements
    assert not any("measurement_profiles" in statement for statement in statements)


@pytest.mark.parametrize("question", QUESTIONS)
@pytest.mark.parametrize("any_url", ["sqlite"], indirect=True)
def test_every_question_finds_its_rows_by_an_index(filled, asked, question):
    for statement, parameters in asked(QUESTIONS[question]):
        with filled.look() as session:
            connection = session.connection()
            plan = connection.exec_driver_sql(f"EXPLAIN QUERY PLAN {statement}", parameters)
            steps = [row[3] for row in plan]
        # A SCAN without an index would read the whole table.
        assert [step for step in steps if re.match(r"SCAN \w+$", step)] == []


def test_the_bench_prints_a_row_for_each_question_and_says_what_is_asked():
    table = bench_service_store(silent, measurements=40, asked=2)
    assert table.title.startswith("Questions to a store of 40 measurements")
    assert table.rows[0]["asked"] == "<= 50"
    assert len(table.rows) == 6
