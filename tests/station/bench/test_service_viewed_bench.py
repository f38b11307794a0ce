"""Shows that the bench of live pictures judges what it saw; what it sees is no test's business."""

import pytest

from station.bench import BENCHES
from station.bench.service import bench_service_viewed
from station.bench.service.open_loop import Answered
from station.bench.service.viewed import _Stretch, _table
from station.progress import silent

RECORDING = {"recorded": 430, "lost": 0, "refused": 0}


def stretch(took_ms, status=200, views=()):
    calls = [Answered(f"{kind} x", status, took_ms, 0.0) for kind in ("GET", "PUT") for _ in "123"]
    views = [Answered("view", each, 30.0, 0.0) for each in views]
    return _Stretch(calls, views, 0.5, 5.0)


def table_of(alone, looked):
    return _table({False: alone, True: looked}, RECORDING, 100.0)


def test_the_bench_is_found_by_its_name():
    assert BENCHES["service-viewed"] == (bench_service_viewed,)


def test_calls_may_hardly_take_longer_while_somebody_looks():
    alone = [stretch(20.0)]
    assert [row["holds"] for row in table_of(alone, [stretch(26.0)]).rows] == [True, True]
    assert [row["holds"] for row in table_of(alone, [stretch(28.0)]).rows] == [False, False]


def test_one_stall_of_the_host_is_told_and_does_not_judge():
    looked = [stretch(21.0), stretch(900.0), stretch(20.0)]
    for row in table_of([stretch(20.0)] * 3, looked).rows:
        assert (row["p99 looked at"], row["from, to, looked at"]) == (21.0, "20 to 900")
        assert row["holds"]


def test_a_call_that_fails_breaks_what_is_asked():
    rows = table_of([stretch(20.0)], [stretch(1.0, status=503)]).rows
    assert [(row["failed"], row["holds"]) for row in rows] == [(3, False), (3, False)]


def test_pictures_processors_and_frames_are_told():
    table = table_of([stretch(20.0)], [stretch(20.0, views=(200, 200, 503))])
    assert [row["count"] for row in table.rows] == [3, 3]
    _, pictures, processors, recorded = table.notes
    assert "2 of 3 served, p50 30 ms" in pictures
    assert "10.0, looked at 10.0" in processors
    assert "430 frames, lost 0" in recorded


@pytest.mark.slow  # some 20 s of two quiet cores: all processes of a station start
def test_the_bench_looks_at_a_station_that_records_and_no_call_fails():
    table = bench_service_viewed(silent, seconds=2.0, rounds=1, rate_hz=20.0)
    assert [row["failed"] for row in table.rows] == [0, 0]
    served, _, asked = table.notes[1].split()[1:4]
    assert (int(served) > 0, asked) == (True, "40")
