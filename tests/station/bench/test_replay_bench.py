"""The bench of replaying does each piece of work on every frame."""

import pytest

from station.bench.replay import bench_replay
from station.progress import silent


def test_every_piece_of_work_takes_longer_than_the_one_within_it():
    table = bench_replay(silent, wheels=1, runs=1)
    rates = [row["frames/s of a core"] for row in table.rows]
    assert rates == sorted(rates, reverse=True)
    assert table.rows[0]["times reading alone"] == pytest.approx(1.0)
