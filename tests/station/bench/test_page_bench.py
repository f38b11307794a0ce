"""Shows that the bench of pages judges what it saw, and says what it lacks.

That it opens the pages of a station at work is shown by the slow one; its times are no claims.
"""

import sys
from pathlib import Path

import pytest

from station.bench import page_browser
from station.bench.page import ASKED_MS, bench_page, table_of
from station.bench.page_browser import Visit
from station.errors import InputUnusable
from station.progress import silent

RECORDING = {"recorded": 100, "lost": 0, "refused": 0}


def held(table):
    return {row["what"]: row["holds"] for row in table.rows}


def test_a_page_that_is_late_or_heavy_does_not_hold():
    seen = {"/quick": [Visit(400.0, 90_000)], "/slow": [Visit(ASKED_MS + 1.0, 150_001)]}
    assert held(table_of(seen, [20.0], RECORDING)) == {
        "/quick, interactive": True,
        "/quick, over the wire": True,
        "/slow, interactive": False,
        "/slow, over the wire": False,
        "a profile of 2000 points, drawn": True,
    }


def test_the_figure_is_the_median_of_the_visits():
    visits = [Visit(float(ms), 1000) for ms in (100, 5000, 300)]
    row = table_of({"/now": visits}, [60.0, 10.0, 20.0], RECORDING).rows[0]
    assert (row["median"], row["max"], row["holds"]) == (300.0, 5000.0, True)


def test_where_there_is_no_browser_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setattr(page_browser, "_CHROMIUM", Path("/nowhere/chromium"))
    with pytest.raises(InputUnusable, match="apt-get install chromium"):
        bench_page(silent)


def test_where_nothing_drives_a_browser_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    with pytest.raises(InputUnusable, match="pip install playwright"):
        bench_page(silent)


@pytest.mark.slow
def test_every_page_is_opened_while_a_train_is_recorded():
    table = bench_page(silent, visits=1)
    assert len(table.rows) == 11
    assert all(row["median"] > 0.0 for row in table.rows)
    assert "lost 0, refused 0" in table.notes[1]
