"""Shows that the fleet's pages are whole, tell what the fleet knows, and are written once.

How they look, and that a browser runs nothing in them, is shown with the other pages.
"""

import json
import re
from datetime import timedelta
from pathlib import Path

import pytest
from fleet_stations import BEGAN, fleet_of_two, night_of
from sqlalchemy import delete

from measure import Alarm, Limit, Limits, Quantity, Side
from station.cli.main import build_app, run
from station.fleet.pages import addresses, folder
from station.fleet.tables import FleetAxle
from station.store import sqlite_url
from station.store.measured import axles_of

HOSTILE = "<script>alert(1)</script>"


@pytest.fixture
def url(tmp_path):
    return sqlite_url(tmp_path / "fleet.sqlite")


@pytest.fixture
def two(tmp_path, url):
    with fleet_of_two(tmp_path, url) as stations:
        yield stations


@pytest.fixture
def written(url, tmp_path, capsys):
    """Have the pages written: exit code, what was said, and the folder."""
    app = build_app("fleet")

    def write(*arguments, out=tmp_path / "pages"):
        code = run(app, ["fleet", "page", "--out", str(out), "--url", url, *arguments])
        said, refused = capsys.readouterr()
        return code, (json.loads(said) if "--json" in arguments else said or refused), out

    return write


def wheel_text(out, wheelset="ws-0", side=Side.LEFT):
    return (out / addresses.wheel_address(wheelset, side)).read_text()


def test_all_pages_are_there_and_lead_to_each_other(two, written):
    north, _ = two
    north.train(0, axles=1)
    north.push()
    code, _, out = written()
    assert code == 0
    pages = {path.relative_to(out).as_posix() for path in out.rglob("*.html")}
    assert len(pages) == 4  # overview, sensors, one group of names, one wheel
    for page in pages:
        for target in re.findall(r'href="([^"#]+)', (out / page).read_text()):
            assert ((out / page).parent / target).is_file(), (page, target)


def test_they_come_of_a_postgresql_too(postgres, tmp_path):
    url, out = postgres.empty_database(), tmp_path / "pages"
    with fleet_of_two(tmp_path, url) as (north, _):
        north.train(0, axles=1)
        north.push()
        assert run(build_app("fleet"), ["fleet", "page", "--out", str(out), "--url", url]) == 0
    assert "not over 36 mm" not in wheel_text(out)  # so far away it is not drawn, but said
    assert "One value tells no wear. 6.00\N{NARROW NO-BREAK SPACE}mm left to 36 mm." in wheel_text(
        out
    )


def test_a_wheels_page_has_both_stations_the_limit_and_all_values(two, written):
    north, south = two
    for number in range(6):
        north.train(number, axles=1, value=35.0 + 0.05 * number)
    for number in range(3):
        south.train(number, axles=1, value=35.4, at=BEGAN + timedelta(days=number, hours=5))
    north.push()
    south.push()
    text = wheel_text(written()[2])
    assert text.count('class="marks c0"') == 2  # in the legend and in the drawing
    assert text.count('class="marks c1"') == 2
    assert "not over 36 mm" in text
    assert "they disagree" in text
    assert text.count("<tr>") == 1 + 9
    assert "35.25\N{NARROW NO-BREAK SPACE}mm \N{PLUS-MINUS SIGN} 0.05" in text


def test_the_overview_tells_of_stations_sensors_and_the_wheels_that_matter(two, written):
    north, south = two
    for number in range(6):
        north.train(number * 30, axles=1, value=34.0 + 0.3 * number)
    north.push()
    night_of(south)
    south.push()
    text = (written()[2] / "index.html").read_text()
    assert "As the fleet knew it at 20" in text
    assert "calibration in doubt: left" in text
    assert '<span class="badge bad">in doubt</span>' in text
    assert "At their limit soonest" in text
    # 0.5 mm are left, 0.3 mm a month go: 50 days after the last pass, of 28 November.
    assert re.search(r"ws-0, left wheel</a>.*?2027-01-1\d", text, re.DOTALL)


def test_a_calibration_is_due_so_long_after_it_was_made(two, written):
    _, south = two
    night_of(south, alarm=False)
    south.push()
    index = written("--due-after", "1")[2] / "index.html"
    assert "overdue" in index.read_text()
    written("--due-after", "9999")
    assert "None is in doubt, none is due" in index.read_text()


def test_a_limit_that_a_station_tells_is_the_one_drawn(two, written):
    north, _ = two
    north.limits = Limits("ours", {Quantity.FLANGE_HEIGHT: Limit(high_mm=30.7)})
    for number in range(3):
        north.train(number, axles=1, value=30.2)
    north.push()
    assert "not over 30.7 mm" in wheel_text(written()[2])


def test_written_again_only_what_changed_is_written(two, written):
    north, _ = two
    north.train(0)
    north.push()
    _, first, out = written("--json")
    before = {path: path.stat().st_mtime_ns for path in out.rglob("wheels/*.html")}
    _, again, _ = written("--json")
    assert first["written"] == first["pages"]
    assert again["written"] <= 2  # those that say when they were made
    assert {path: path.stat().st_mtime_ns for path in before} == before
    with north.store.change() as session:
        axles_of(session, "p00000")[0].jumps = {"flange_height": {"change": 1.0}}
    north.push()
    _, changed, _ = written("--json")
    assert again["written"] < changed["written"] <= 2 + 2  # the wheel, and its group of names
    assert "jumped +1.00" in wheel_text(out)


def test_a_wheel_that_the_fleet_forgets_loses_its_page_and_nothing_else_goes(two, written):
    north, _ = two
    north.train(0)
    north.push()
    out = written()[2]
    mine = out / "wheels" / "mine.html"
    mine.write_text("mine")
    with north.fleet.change() as session:
        session.execute(delete(FleetAxle).where(FleetAxle.wheelset == "ws-0"))
    assert written("--json")[1]["removed"] == 1
    assert mine.exists()
    assert not (out / addresses.wheel_address("ws-0", Side.LEFT)).exists()


def test_names_are_never_markup_and_never_a_path(two, written):
    north, _ = two
    names = [HOSTILE, "../../etc/passwd", 'a" onload="x', "\N{GREEK SMALL LETTER ALPHA}"]
    north.name = HOSTILE
    for number, name in enumerate(names):
        north.train(number, axles=1, wheelset=name)
    north.push()
    out = written()[2]
    pages = list(out.rglob("*.html"))
    assert len(pages) == 4 + len(names) - 1
    for page in pages:
        assert page.resolve().is_relative_to(out)
        text = page.read_text()
        assert "<script" not in text
        assert 'onload="x' not in text
    assert "&lt;script&gt;" in (out / "index.html").read_text()


def test_an_empty_fleet_says_so_in_a_line_each(url, written):
    run(build_app("fleet"), ["fleet", "init", "--url", url])
    code, _, out = written()
    text = (out / "index.html").read_text()
    assert code == 0
    for line in ("No station has sent anything yet.", "No calibration is in force anywhere.",
                 "No wheel has been measured at a place that is certain"):  # fmt: skip
        assert text.count(line) == 1


def test_a_fleet_that_is_not_reached_is_said_on_the_pages_that_stay(two, written, tmp_path, capsys):
    north, _ = two
    north.train(0)
    north.push()
    out = written()[2]
    before = (out / "index.html").read_text()
    away = f"postgresql://nobody@/none?host={tmp_path}"
    for _ in range(2):
        assert run(build_app("fleet"), ["fleet", "page", "--out", str(out), "--url", away]) == 2
    assert capsys.readouterr().err.count("\n") == 2
    text = (out / "index.html").read_text()
    assert text.count("The fleet was not reached at") == 1
    assert re.sub(r'<p class="refused".*?</p>', "", text) == before
    assert written()[0] == 0
    assert "not reached" not in (out / "index.html").read_text()


def test_a_fleet_that_was_never_reached_has_a_page_that_says_so(tmp_path):
    away, out = f"postgresql://nobody@/none?host={tmp_path}", tmp_path / "new"
    assert run(build_app("fleet"), ["fleet", "page", "--out", str(out), "--url", away]) == 2
    assert "The fleet was not reached at" in (out / "index.html").read_text()


def test_a_folder_of_something_else_is_refused(two, written, tmp_path):
    (tmp_path / "pages").mkdir()
    (tmp_path / "pages" / "thesis.txt").write_text("mine")
    code, said, out = written()
    assert code == 2
    assert "holds something else" in said
    assert [path.name for path in out.iterdir()] == ["thesis.txt"]


def test_a_run_that_was_killed_leaves_a_folder_for_the_next(two, written):
    north, _ = two
    north.train(0)
    north.push()
    out = written()[2]
    (out / "index.html").unlink()
    (out / "sensors.html").unlink()
    assert written()[0] == 0


def test_a_page_is_whole_or_not_there_at_all(tmp_path, monkeypatch):
    made = folder.PagesFolder.prepared(tmp_path / "pages")
    made.put("index.html", "first")

    def cut_off(_self, _target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", cut_off)
    with pytest.raises(Exception, match="No space left"):
        made.put("index.html", "second")
    monkeypatch.undo()
    assert [path.name for path in (tmp_path / "pages").glob("*index*")] == ["index.html"]
    assert (tmp_path / "pages" / "index.html").read_text() == "first"


def test_alarms_and_warnings_stand_beside_their_values(two, written):
    north, _ = two
    north.train(0, axles=1, alarm=Alarm.ALARM)
    north.push()
    out = written()[2]
    assert wheel_text(out).count('<span class="badge bad">alarm</span>') == 2
    assert '<span class="badge bad">1 in its last pass</span>' in (out / "index.html").read_text()
