"""Does the bench of kills find what it looks for?  A short train past a real station; that a fault
is seen at all is shown by planting it.  How often a kill costs what is for the bench itself."""

import os
import sqlite3
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from newest_schema import make_store
from sqlalchemy import select

from station.bench import BENCHES
from station.bench.processes import parent_of
from station.bench.service.kill_trials import Train, Trial, run_kills
from station.bench.service.kills import table_of
from station.bench.service.pass_truth import PassTruth, left_over, named_memory, truth_of_pass
from station.bench.service.small_sensor import (
    CALIBRATION_ID,
    SENSOR,
    bring_calibration_into_force,
    render_wheels,
    true_calibration,
)
from station.bench.service.station_process import StationProcess, Victim
from station.cli.main import build_app, run
from station.operations import DataLayout, utc_now
from station.pipeline import measure_sources
from station.progress import silent
from station.recording import RecordingWriter, active_path
from station.store import JobKind, Measurement, Pass, PassState, Recording, Store, add_job
from station.store.measured import add_measurements

SHORT = Train(wheels=3)
SOUND = PassTruth(recorded=3, lost=0, unsaid=0, unsound=0, missing=0, doubled=0, differing=0)
GOOD = Trial(
    victim=Victim.API,
    after_s=1.0,
    state="done",
    reason="",
    ready_s=2.0,
    truth=SOUND,
    left_over=(),
    next_whole=True,
    server_errors=0,
)


@pytest.mark.parametrize(
    ("kills", "victims"),
    [
        # The death of the others, whose restart takes longer, is beside `station serve`'s tests.
        (1, [Victim.RECORDER, Victim.WORKER]),
        pytest.param(3, list(Victim), marks=pytest.mark.slow),
    ],
)
def test_no_kill_loses_what_was_recorded_or_doubles_a_reading(kills, victims):
    trials = run_kills(silent, kills=kills, victims=victims, train=SHORT, seed=5)
    assert [trial for trial in trials if not trial.good] == []
    assert [trial.victim for trial in trials] == victims * kills


@pytest.fixture(scope="module")
def pictures():
    return render_wheels(3)


@pytest.fixture
def ground(tmp_path, pictures):
    """A measured pass of three wheels, as a station leaves it: its layout and its store."""
    layout = DataLayout(tmp_path / "data")
    make_store(layout.store_url)
    bring_calibration_into_force(layout)
    store = Store.open(layout.store_url)
    path = layout.root / layout.pass_recording("p1", SENSOR)
    path.parent.mkdir(parents=True)
    with RecordingWriter(path) as writer:
        for number, picture in enumerate(pictures, start=1):
            height, width = picture.shape
            time_ns = number * 10**9
            writer.write_frame(
                SENSOR, number, time_ns, time_ns, picture.data.cast("B"), width, height
            )
    with store.change() as session:
        session.add(Pass(id="p1", state=PassState.DONE, opened_at=utc_now()))
        session.flush()
        session.add(
            Recording(
                id="pass.p1.left",
                sensor=SENSOR,
                pass_id="p1",
                path=str(path.relative_to(layout.root)),
                opened_at=utc_now(),
                calibration_id=CALIBRATION_ID,
                recorded=3,
                lost=1,
                recovered=False,
            )
        )
        session.flush()
        found = measure_sources([path], true_calibration())
        add_measurements(session, [_reading(wheel) for wheel in found.wheels])
    yield layout, store
    store.close()


def _reading(wheel):
    return Measurement(
        recording_id="pass.p1.left",
        frame=wheel.frame,
        calibration_id=CALIBRATION_ID,
        sensor=SENSOR,
        pass_id="p1",
        reference="S1002",
        software="treadline 0",
        measured_at=utc_now(),
        wheel=wheel.model_dump(mode="json"),
    )


def reading_of(session, frame):
    return session.scalars(select(Measurement).where(Measurement.frame == frame)).one()


def test_a_pass_that_is_as_its_files_say_is_found_so(ground):
    layout, store = ground
    assert truth_of_pass(store, layout, "p1", triggers=4) == replace(SOUND, lost=1)


def test_frames_that_the_account_does_not_tell_are_counted(ground):
    layout, store = ground
    truth = truth_of_pass(store, layout, "p1", triggers=6)
    assert (truth.lost, truth.unsaid) == (3, 2)


def test_readings_that_are_missing_or_differ_are_counted(ground):
    layout, store = ground
    with store.change() as session:
        reading_of(session, 2).frame = 7
        changed = reading_of(session, 3)
        changed.wheel = {**changed.wheel, "tread_wear": None}
    truth = truth_of_pass(store, layout, "p1", triggers=4)
    assert (truth.missing, truth.doubled, truth.differing) == (1, 0, 2)


def test_a_reading_that_is_there_twice_is_counted(ground):
    layout, store = ground
    with store.change() as session:
        # What the store's index does not let in: a fault of the index itself.
        session.connection().exec_driver_sql("DROP INDEX uq_measurements_of_sensors")
        first = reading_of(session, 1)
        again = {
            column.key: getattr(first, column.key)
            for column in Measurement.__table__.columns
            if column.key != "id"
        }
        session.add(Measurement(**again))
    assert truth_of_pass(store, layout, "p1", triggers=4).doubled == 1


@pytest.fixture
def station(ground, tmp_path):
    """A station on that ground that does not run: what is left over is its folder's."""
    layout, _ = ground
    with sqlite3.connect(layout.jobs_file) as jobs:
        jobs.execute("CREATE TABLE workflow_status (workflow_uuid TEXT, status TEXT)")
        jobs.execute("INSERT INTO workflow_status VALUES ('w0', 'SUCCESS')")
    jobs.close()
    return StationProcess(tmp_path, "", SENSOR)


def test_a_station_at_rest_has_nothing_left_over(ground, station):
    assert left_over(station, ground[1]) == []


def test_everything_that_is_left_over_is_named(ground, station, tmp_path):
    layout, store = ground
    with sqlite3.connect(layout.jobs_file) as jobs:
        jobs.execute("INSERT INTO workflow_status VALUES ('w1', 'PENDING')")
    jobs.close()
    with store.change() as session:
        add_job(session, "j1", JobKind.MEASURE, "p1", at=utc_now())
    passes = layout.root / "recordings/passes"
    active_path(passes / "p1/left.mcap").touch()
    (passes / "stray.mcap").touch()
    for name in ("treadline-now", "treadline-of-a-killed-one"):
        (tmp_path / name).mkdir()
    own = os.environ | {"TMPDIR": str(tmp_path)}
    # A process that has just begun shows an empty environment for a moment: it speaks first.
    speaks_and_waits = [sys.executable, "-c", "print('here', flush=True); input()"]
    pipe = subprocess.PIPE
    with subprocess.Popen(speaks_and_waits, env=own, stdin=pipe, stdout=pipe) as one:
        assert one.stdout is not None
        assert one.stdout.readline() == b"here\n"
        found = left_over(station, store)
        assert station.orphans() == {one.pid}
        assert parent_of(one.pid) == os.getpid()
        one.kill()
    assert sorted(found) == sorted([
        "job j1 is queued",
        "left.mcap.active is unfinished",
        "recordings/passes/stray.mcap is in no row",
        f"process {one.pid} is nobody's",
        "workflow w1 is PENDING",
        "treadline-of-a-killed-one is left",
    ])


@pytest.mark.parametrize(
    "worse",
    [
        {"state": "measuring"},
        {"state": "failed"},
        {"truth": replace(SOUND, unsaid=1)},
        {"truth": replace(SOUND, unsound=1)},
        {"truth": replace(SOUND, missing=1)},
        {"truth": replace(SOUND, doubled=1)},
        {"truth": replace(SOUND, differing=1)},
        {"left_over": ("job j1 is running",)},
        {"next_whole": False},
    ],
)
def test_a_kill_that_costs_something_does_not_hold(worse):
    bad = replace(GOOD, **worse)
    assert GOOD.good
    assert not bad.good
    table = table_of([GOOD, bad], SHORT)
    (row,) = table.rows
    assert (row["killed"], row["times"], row["holds"]) == ("api", 2, False)
    assert len(table.notes) == 2


def test_a_pass_that_failed_is_told_and_held_against_the_station_only_with_frames_on_the_disk():
    empty = replace(SOUND, recorded=0, lost=3)
    failed = replace(GOOD, state="failed", reason="no frame was recorded", truth=empty)
    assert failed.good
    assert "no frame was recorded" in table_of([failed], SHORT).notes[-1]


def test_the_named_memory_of_a_station_is_found(station, tmp_path):
    script = "import mmap, os; f = open(os.environ['NAMED'], 'r+b')"
    named = Path(f"/dev/shm/treadline-test-{os.getpid()}")  # noqa: S108  where the system has it
    named.write_bytes(bytes(4096))
    own = os.environ | {"TMPDIR": str(tmp_path), "NAMED": str(named)}
    command = [sys.executable, "-c", f"{script}; m = mmap.mmap(f.fileno(), 0); print(); input()"]
    pipe = subprocess.PIPE
    try:
        with subprocess.Popen(command, env=own, stdin=pipe, stdout=pipe) as one:
            one.stdout.readline()
            assert named_memory(station) == [f"process {one.pid} maps {named}"]
            one.kill()
    finally:
        named.unlink()


def test_both_lengths_are_to_be_had_from_the_command_line(monkeypatch, capsys):
    asked = []

    def bench(progress, *, full=False):
        asked.append(full)
        return table_of([GOOD], SHORT)

    monkeypatch.setattr("station.cli.bench.bench_service_kills", bench)
    monkeypatch.setitem(BENCHES, "service-kills", (bench,))
    for options in ([], ["--full"]):
        assert run(build_app("bench"), ["bench", "service-kills", "--json", *options]) == 0
    assert asked == [False, True]
    assert '"killed": "api"' in capsys.readouterr().out
    assert run(build_app("bench"), ["bench", "service-kills", "--minutes", "1"]) == 2
