"""The benches that workers do, on little: nothing is lost, figures are those of one process.

What is asked of times is not judged: other work runs on the cores.
"""

from contextlib import nullcontext

import numpy as np
import pytest

import station.bench.drawing as drawing
import station.bench.measure_intervals as measure_intervals
import station.bench.replay_many as replay_many
from station.bench import (
    DRAWN,
    Drawing,
    bench_intervals,
    bench_paper_draws,
    bench_piece_u95,
    bench_pose_sets,
    bench_rig_intervals,
    bench_sweeps,
)
from station.cli.main import build_app, run
from station.errors import StationError
from station.progress import silent
from station.replay import Here, local_workers


@pytest.fixture(scope="module")
def two_workers():
    with local_workers(2) as workers:
        yield workers


@pytest.fixture
def few_starts(monkeypatch, two_workers):
    """Have one worker and two be the same two: to start others takes seconds."""
    monkeypatch.setattr(replay_many, "local_workers", lambda _count: nullcontext(two_workers))


@pytest.mark.usefixtures("few_starts")
def test_nothing_is_lost_or_doubled_whatever_happens_to_workers_and_recordings():
    rows = replay_many.bench_replay_many(silent, short=True).rows
    held = {row["what"]: row["holds"] for row in rows}
    times = [what for what in held if what.endswith(("times", "share more"))]
    assert len(times) == 4
    assert {what: holds for what, holds in held.items() if what not in times} == {
        "bytes of the table that differ by the number of workers": True,
        "recordings lost with a killed worker": True,
        "bytes of the table that differ after it": True,
        "named of 6 recordings, one of them damaged": True,
        "others in the table": True,
        "memory of a worker after 2, 20 frames at once, MB": True,
    }


LEFT_OPEN = np.diag([1e-4] * 9 + [1e-10] * 3 + [1e-6])
DRAWN_ON_LITTLE = {
    bench_paper_draws: {"draws": 3, "poses": 4},
    bench_sweeps: {"poses": 4, "runs": 2, "levels_px": (0.5, 1.0)},
    bench_pose_sets: {"sets": 3, "poses": 4, "runs": 1},
    bench_intervals: {"draws": {1: 4, 2: 2}},
    bench_rig_intervals: {"wheels": 3, "several": 2, "shots": 2},
    bench_piece_u95: {"pictures": 4, "runs": 1},
}


def named(bench):
    shown = bench in {bench_paper_draws, bench_intervals}
    return pytest.param(bench, id=bench.__name__, marks=() if shown else pytest.mark.slow)


@pytest.mark.parametrize("bench", [named(one) for one in DRAWN_ON_LITTLE])
def test_draws_are_the_same_whoever_does_them(bench, two_workers, monkeypatch):
    size = DRAWN_ON_LITTLE[bench]
    monkeypatch.setattr(drawing, "_TASK_S", 0.0)  # each draw a task of its own
    # To render pictures for what a calibration leaves open takes longer than all draws.
    monkeypatch.setattr(measure_intervals, "calibrated_covariance", lambda _seed: LEFT_OPEN)
    alone = bench(silent, **size)
    shared = bench(silent, **size, drawing=Drawing(two_workers))
    np.testing.assert_equal(shared.rows, alone.rows)  # a figure of too few draws is NaN


def test_draws_come_in_their_order_whenever_they_are_done():
    class Backwards(Here):
        def each(self, work, tasks):
            return reversed(list(super().each(work, tasks)))

    answers = Drawing(Backwards()).map(str, range(25), seconds_each=0.1)
    assert list(answers) == [str(number) for number in range(25)]


def test_a_draw_that_cannot_be_done_ends_the_bench_in_one_line():
    answers = Drawing(Here()).map(int, ["1", "two"], seconds_each=1.0)
    assert next(answers) == 1
    with pytest.raises(StationError, match="draw 1 and those behind it not done: ValueError"):
        next(answers)


def test_a_cluster_is_of_the_benches_that_draw(capsys):
    assert run(build_app("bench"), ["bench", "stripe", "--cluster=tcp://127.72.2.1:9"]) == 2
    assert "--cluster is of `station bench` calibration, measure" in capsys.readouterr().err


def test_every_bench_that_draws_takes_a_cluster():
    assert {one for some in DRAWN.values() for one in some} == set(DRAWN_ON_LITTLE)
