"""Shows what `station fleet` tells of several stations, in lines and as JSON."""

import json
from datetime import timedelta

import pytest
from fleet_stations import BEGAN, calibration, fleet_of_two, night_of

from measure import Alarm
from station.cli.main import build_app, run
from station.fleet import fleet_trend
from station.store import (
    Actor,
    Calibration,
    activate,
    sqlite_url,
)
from station.store.measured import axles_of


@pytest.fixture
def url(tmp_path):
    return sqlite_url(tmp_path / "fleet.sqlite")


@pytest.fixture
def fleet_command(url, capsys):
    """Run `station fleet ARGUMENTS`: exit code, and what is printed, or said on stderr."""
    app = build_app("fleet")

    def command(*arguments):
        code = run(app, ["fleet", *arguments, "--url", url])
        out, err = capsys.readouterr()
        return code, (json.loads(out) if "--json" in arguments and out else out or err)

    return command


@pytest.fixture
def stations(tmp_path, url):
    """Two stations that saw the same wheelset; south reads 0.3 mm more."""
    with fleet_of_two(tmp_path, url) as (north, south):
        for number in range(6):
            north.train(number, axles=1, value=30.0)
        for number in range(3):
            at = BEGAN + timedelta(days=number, hours=5)
            south.train(number, axles=1, value=30.3, at=at, alarm=Alarm.ALARM)
        night_of(south)
        north.push()
        south.push()
        yield north, south


def test_init_makes_the_tables_and_a_second_time_changes_nothing(fleet_command):
    code, first = fleet_command("init", "--json")
    assert (code, first["before"], first["revision"]) == (0, None, "f0002")
    assert fleet_command("init", "--json")[1]["before"] == "f0002"


@pytest.mark.parametrize("is_there", [True, False])
def test_a_database_without_tables_is_refused_in_a_line_and_none_is_made(
    fleet_command, tmp_path, is_there
):
    file = tmp_path / "fleet.sqlite"
    if is_there:
        file.touch()
    code, said = fleet_command("status")
    assert code == 2
    assert "no tables yet; run `station fleet init`" in said
    assert said.count("\n") == 1
    assert file.exists() == is_there


def test_without_an_address_it_is_said_where_to_give_one(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(build_app("fleet"), ["fleet", "status"]) == 2
    assert "give --url postgresql://" in capsys.readouterr().err


def test_the_address_is_taken_from_environment_or_settings(url, capsys, tmp_path, monkeypatch):
    config = tmp_path / "station.toml"
    text = 'data_dir = "data"\n[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
    config.write_text(f'{text}[fleet]\nurl = "{url}"\n')
    app = build_app("fleet")
    assert run(app, ["fleet", "init", "--config", str(config)]) == 0
    monkeypatch.setenv("STATION_FLEET_URL", url)
    capsys.readouterr()
    assert run(app, ["fleet", "init", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["before"] == "f0002"


def test_status_tells_of_every_station(stations, fleet_command):
    code, found = fleet_command("status", "--json")
    assert code == 0
    by_name = {each["station"]: each for each in found["stations"]}
    assert {name: each["passes"] for name, each in by_name.items()} == {"north": 6, "south": 3}
    assert by_name["south"]["alarms"] == 1
    assert by_name["south"]["doubtful"] == ["left"]
    assert by_name["north"]["unsent"] == 0
    _, text = fleet_command("status")
    assert "calibration in doubt: left; 1 alarms in its last pass" in text
    assert len(text.strip().splitlines()) == 3


def test_health_tells_age_residuals_and_drift_and_exits_1_in_doubt(stations, fleet_command):
    code, found = fleet_command("health", "--json")
    assert code == 1
    (sensor,) = found["sensors"]
    assert (sensor["station"], sensor["name"], sensor["version"]) == ("south", "left", 1)
    assert (sensor["rms_dots_px"], sensor["drift_rms_mm"]) == (0.11, 0.21)
    assert sensor["doubtful"]
    assert "IN DOUBT" in fleet_command("health")[1]
    assert fleet_command("health", "--station", "north")[0] == 0


def test_trend_shows_that_two_stations_disagree(stations, fleet_command):
    code, found = fleet_command("trend", "ws-0", "--json")
    assert code == 0
    assert found["stations"] == ["north", "south"]
    (side,) = found["sides"]
    height = side["quantities"]["flange_height"]
    assert len(height["values"]) == height["compared"] == 9
    (offset,) = height["agreement"]["offsets"]
    assert offset["station"] == "south"
    assert offset["offset_mm"] == pytest.approx(0.3, abs=0.01)
    assert not offset["agrees"]
    assert "south +0.300 ± 0.0" in fleet_command("trend", "ws-0")[1]


def test_trend_of_a_wheelset_that_nobody_measured_exits_1(stations, fleet_command):
    code, said = fleet_command("trend", "no-such")
    assert code == 1
    assert "no station has measured it" in said


def test_what_came_before_a_jump_is_shown_and_not_compared(stations):
    north, south = stations
    with north.store.change() as session:
        (axle,) = axles_of(session, "p00003")
        axle.jumps = {"flange_height": {"change": 1.0}}
    north.push()
    with north.fleet.look() as session:
        trend = fleet_trend(session, "ws-0")
    (height,) = trend.sides[0].quantities.values()
    assert (len(height.values), height.compared) == (9, 3)
    assert height.agreement is None


def test_a_night_against_an_earlier_calibration_is_no_doubt_of_the_present(stations, fleet_command):
    _, south = stations
    with south.store.change() as session:
        session.add(calibration("e"))
        session.flush()
        new = session.get_one(Calibration, "e")
        activate(session, new, sensor="left", seen=1, by=Actor("somebody"), at=BEGAN)
    south.push()
    code, found = fleet_command("health", "--json")
    assert code == 0
    assert [each["version"] for each in found["sensors"]] == [2]


def test_two_stores_that_send_under_one_name_are_told(stations, fleet_command):
    north, south = stations
    south.name = "north"
    south.push()
    assert rivals(fleet_command) == {"north": 0, "south": 0}  # as after a restore
    north.push()
    assert rivals(fleet_command) == {"north": 1, "south": 0}
    assert "SEVERAL STORES SEND UNDER ITS NAME" in fleet_command("status")[1]


def rivals(fleet_command):
    _, found = fleet_command("status", "--json")
    return {each["station"]: each["rivals"] for each in found["stations"]}
