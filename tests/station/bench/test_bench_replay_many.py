"""The bench of replaying many recordings does all of it, on little; its times are no figures here.

What is asked of times is not judged: other work runs on the cores.
"""

from contextlib import nullcontext

import pytest

import station.bench.replay_many as replay_many
from station.progress import silent
from station.replay import local_workers


@pytest.fixture
def few_starts(monkeypatch):
    """Have one worker and two be the same two: to start others takes seconds."""
    with local_workers(2) as workers:
        monkeypatch.setattr(replay_many, "local_workers", lambda _count: nullcontext(workers))
        yield


@pytest.mark.usefixtures("few_starts")
def test_nothing_is_lost_or_doubled_whatever_happens_to_workers_and_recordings():
    rows = replay_many.bench_replay_many(silent, short=True).rows
    held = {row["what"]: row["holds"] for row in rows}
    times = [what for what in held if what.endswith(("times", "share more"))]
    assert len(times) == 3
    assert {what: holds for what, holds in held.items() if what not in times} == {
        "bytes of the table that differ by the number of workers": True,
        "recordings lost with a killed worker": True,
        "bytes of the table that differ after it": True,
        "named of 6 recordings, one of them damaged": True,
        "others in the table": True,
        "memory of a worker after 2, 20 frames at once, MB": True,
    }
