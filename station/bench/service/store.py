"""How long the questions of planners take where a million wheels were measured."""

import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from sqlalchemy.orm import Session

from measure import Limits, Side
from station.bench.figures import Row, figure
from station.bench.service.filled_store import Traffic, fill
from station.progress import Progress
from station.store import Store, migrate, sqlite_url
from station.store.lists import measurements_page
from station.store.measured import places_of
from station.tables import Table
from station.trains import wheelset_trend

ASKED_TREND_MS = 50.0
_PAGE = 100

Question = Callable[[Session, int], object]
"""Asked in a session, the how-manieth time."""


def bench_service_store(
    progress: Progress, *, measurements: int = 1_000_000, asked: int = 200, url: str | None = None
) -> Table:
    """Fill a store and ask it for trends and lists, each time of other wheels.

    Parameters
    ----------
    progress
        Told where the bench is.
    measurements
        Wheels in the store; as many whole trains as hold them.
    asked
        How often each question is asked.
    url
        An empty database; a file of SQLite in a temporary folder where not given.
    """
    axles = min(200, max(measurements // 20, 1))
    traffic = Traffic(passes=-(-measurements // (axles * len(Side))), axles=axles)
    with _empty_store(url) as store:
        fill(store, traffic, progress)
        questions = _questions(traffic)
        rows = []
        for place, (name, question) in enumerate(questions.items()):
            progress(place / len(questions), name)
            rows.append(_row(name, *_times_ms(store, question, asked)))
    return Table(
        f"Questions to a store of {traffic.measurements} measurements, ms",
        rows,
        (
            f"The median of {asked} times by the clock of the wall, their 99th percentile, and the "
            "median of the processor's time, which others on the machine do not lengthen; of "
            "another wheelset, pass or page each time, in a transaction of its own.",
            f"{traffic.passes} passes of {traffic.axles} axles, {traffic.trains} trains in turn.",
        ),
    )


@contextmanager
def _empty_store(url: str | None) -> Generator[Store]:
    with tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder:
        where = url or sqlite_url(Path(folder, "station.sqlite"))
        migrate(where)
        store = Store.open(where)
        try:
            yield store
        finally:
            store.close()


def _questions(traffic: Traffic) -> dict[str, Question]:
    limits = Limits.default()

    def wheelset(turn: int) -> str:
        return traffic.wheelset(turn, 7 * turn % traffic.axles)

    def trend(most: int) -> Question:
        return lambda session, turn: wheelset_trend(session, wheelset(turn), limits, most=most)

    def after(turn: int) -> int:
        return 7919 * turn % traffic.measurements

    def listed(session: Session, **of_which: Any) -> object:
        page = measurements_page(session, limit=_PAGE, **of_which)
        return places_of(session, page.rows)

    return {
        "trend of a wheelset, 100 passes": trend(100),
        "trend of a wheelset, 500 passes": trend(500),
        "list of a wheelset": lambda session, turn: listed(session, wheelset=wheelset(turn)),
        "list of a pass": lambda session, turn: listed(
            session, pass_id=f"p{turn % traffic.passes:06}"
        ),
        "list of a sensor, any page": lambda session, turn: listed(
            session, sensor="left", after=after(turn)
        ),
        "list of all, any page": lambda session, turn: listed(session, after=after(turn)),
    }


def _times_ms(store: Store, question: Question, asked: int) -> tuple[list[float], list[float]]:
    """Return what each asking took by the wall's clock, and by the processor's."""
    wall, core = [], []
    for turn in range(asked):
        began, began_core = time.perf_counter(), time.process_time()
        with store.look() as session:
            question(session, turn)
        wall.append((time.perf_counter() - began) * 1e3)
        core.append((time.process_time() - began_core) * 1e3)
    return wall, core


def _row(name: str, wall_ms: list[float], core_ms: list[float]) -> Row:
    middle, late = np.percentile(wall_ms, [50.0, 99.0])
    of_asked = name == "trend of a wheelset, 100 passes"
    return figure(
        name,
        float(middle),
        f"<= {ASKED_TREND_MS:g}" if of_asked else "-",
        holds=not of_asked or bool(middle <= ASKED_TREND_MS),
        spread=f"p99 {late:.3g}, core {np.median(core_ms):.3g}",
    )
