"""The pages in a browser while a train is recorded: how soon they are of use, what they weigh."""

import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from station.bench.page_browser import Browser, Visit, browser
from station.bench.page_drawing import drawing_of
from station.bench.service.filled_store import Traffic
from station.bench.service.ground import Extent, Ground
from station.bench.service.serving import Serving
from station.documents import WheelDocument
from station.errors import StationError
from station.progress import Progress
from station.tables import Table, Value

ASKED_MS, ASKED_KB, ASKED_DRAWN_MS = 1000.0, 150.0, 50.0
POINTS: Final = 2000
_PAGES: Final = ("/now", "/passes", "/calibration", "/recordings", "/set-up")
_BEFORE, _RUNNING = "before", "running"
_EXTENT: Final = Extent(Traffic(passes=200, axles=8), wheels=4, longest_pass_s=300.0)
_PATIENCE_S = 60.0
_LOOK_S = 0.2


def bench_page(progress: Progress, *, visits: int = 7) -> Table:
    """Open each page as for the first time, again and again, while a station records and measures.

    Parameters
    ----------
    progress
        Told where the bench is.
    visits
        Of each page, each with nothing kept from before.

    Raises
    ------
    InputUnusable
        If there is no browser on this host, or nothing to drive it with.
    """
    with browser() as opened, tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder:
        ground = Ground.prepared(Path(folder), _EXTENT, progress)
        with Serving(ground) as serving:
            progress(0.3, "recording and measuring a train")
            wheel = _measured_wheel(serving)
            serving.client.arm_pass(_RUNNING)
            opened.log_in(f"http://127.0.0.1:{serving.port}", ground.key)
            seen = {page: _visits(opened, page, visits, progress) for page in _PAGES}
            progress(0.9, "drawing a profile")
            drawing = drawing_of(_wheel(serving, wheel), POINTS)
            drawn_ms = [opened.profile_drawn_ms(f"/wheels/{wheel}", drawing) for _ in range(visits)]
            closed = serving.client.finish_pass(_RUNNING, triggers={})
    return table_of(seen, drawn_ms, closed["recordings"][0])


def _measured_wheel(serving: Serving) -> int:
    """Have a train recorded and measured; return the id of one of its wheels."""
    serving.client.arm_pass(_BEFORE)
    until_s = time.monotonic() + _PATIENCE_S
    while not _wheels(serving):
        if time.monotonic() > until_s:
            raise StationError(f"no wheel was measured within {_PATIENCE_S:g} s; see the log")
        time.sleep(_LOOK_S)
    serving.client.finish_pass(_BEFORE, triggers={})
    serving.client.await_pass(_BEFORE, timeout_s=_PATIENCE_S)
    return _wheels(serving)[0]


def _wheel(serving: Serving, measurement: int) -> WheelDocument:
    rows = serving.client.wheels(_BEFORE)
    row = next(row for row in rows if row["id"] == measurement)
    return WheelDocument.model_validate(row["wheel"])


def _wheels(serving: Serving) -> list[int]:
    rows = serving.client.wheels(_BEFORE)
    return [row["id"] for row in rows if row["wheel"]["reason"] is None]


def _visits(opened: Browser, page: str, visits: int, progress: Progress) -> list[Visit]:
    progress(0.4 + 0.5 * _PAGES.index(page) / len(_PAGES), f"opening {page}")
    return [opened.visit(page) for _ in range(visits)]


def table_of(
    seen: Mapping[str, Sequence[Visit]],
    drawn_ms: Sequence[float],
    recording: Mapping[str, int],
) -> Table:
    """Return what was seen beside what is asked, of each page and of the drawing of a profile."""
    rows = [row for page, visits in seen.items() for row in _rows(page, visits)]
    rows.append(_row(f"a profile of {POINTS} points, drawn", drawn_ms, "ms", ASKED_DRAWN_MS))
    notes = (
        f"{len(drawn_ms)} visits each by a headless browser on the same machine, with nothing kept "
        "from before, while one sensor records at full rate and its wheels are measured. "
        "Interactive: from the call to the end of all the page's scripts. Over the wire: what had "
        "come a second later, live pictures included.",
        f"Recorded meanwhile: {recording['recorded']} frames, lost {recording['lost']}, refused "
        f"{recording['refused']}.",
    )
    return Table("Pages while a train is recorded", rows, notes)


def _rows(page: str, visits: Sequence[Visit]) -> list[dict[str, Value]]:
    ready_ms = [visit.interactive_ms for visit in visits]
    weight_kb = [visit.wire_bytes / 1e3 for visit in visits]
    return [
        _row(f"{page}, interactive", ready_ms, "ms", ASKED_MS),
        _row(f"{page}, over the wire", weight_kb, "kB", ASKED_KB),
    ]


def _row(what: str, values: Sequence[float], unit: str, limit: float) -> dict[str, Value]:
    middle, most = float(np.median(values)), float(max(values))
    return {
        "what": what,
        "median": middle,
        "max": most,
        "unit": unit,
        "asked": f"median <= {limit:g}",
        "holds": middle <= limit,
    }
