"""The benches that workers do, on little: nothing is lost, figures are those of one process.

What is asked of times is not judged: other work runs on the cores.
"""

from contextlib import nullcontext

import pytest

import station.bench.paper_draws as paper_draws
import station.bench.replay_many as replay_many
from station.bench import bench_paper_draws
from station.cli.main import build_app, run
from station.progress import silent
from station.replay import local_workers


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


def test_draws_are_the_same_whoever_does_them(two_workers, monkeypatch):
    alone = bench_paper_draws(silent, draws=3, poses=4)
    monkeypatch.setattr(paper_draws, "_DRAWS_EACH", 1)
    shared = paper_draws.draws_by(two_workers, silent, draws=3, poses=4, seed=1)
    assert shared.rows == alone.rows
    assert [row["draws solved"] for row in alone.rows] == [3, 3, 3]


def test_a_cluster_is_of_the_bench_that_draws(capsys):
    assert run(build_app("bench"), ["bench", "stripe", "--cluster=tcp://127.61.0.1:9"]) == 2
    assert "--cluster is of `station bench paper`" in capsys.readouterr().err
