"""`gauge`, `results`, `reference` and what they share with `measure`: files, lines, exit codes."""

import json

import cv2
import numpy as np
import pytest
from profile_files import miniprof_file
from wheel_recordings import true_calibration, views_of

from station.cli.main import build_app, run
from station.scenes import WheelTruth

HEADER = {"Sh": "28.0", "Sd": "32.5", "qR": "10.79"}
CONFIG = """
data_dir = "data"
[[sensors]]
id = "left"
address = "127.0.0.2"
[limits.tread_wear]
high = 0.5
"""


@pytest.fixture
def station(capsys):
    """Run a command; return its exit code, what it printed, and what it refused with."""

    def call(*words):
        code = run(build_app(words[0]), [str(word) for word in words])
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def wheel(tmp_path):
    return miniprof_file(tmp_path / "wheel.whl", HEADER, worn_mm=1.0)


def test_gauge_says_readings_alarms_and_how_far_the_header_is_off(station, wheel):
    code, out, err = station("gauge", wheel)
    assert (code, err) == (0, "")
    assert "wheel.whl: flange_height 29.00" in out
    # The tread is 1 mm lower than the header knows, and with it the face at +10 thicker.
    assert "header says Sh 28.000, Sd 32.500, qR 10.790; the points read Sh +1.000" in out


def test_gauge_as_json_has_the_header_beside_the_readings(station, wheel):
    code, out, _ = station("gauge", wheel, "--json")
    (row,) = json.loads(out)["wheels"]
    assert code == 0
    assert row["header"]["claimed"]["flange_height"] == 28.0
    assert row["flange_height"]["value"] == pytest.approx(29.0, abs=2e-3)


def test_a_header_that_belongs_to_its_points_is_said_to(station, tmp_path):
    code, out, _ = station("gauge", miniprof_file(tmp_path / "a.whl", HEADER))
    assert code == 0
    assert "as the points do within 0.05 mm" in out


def test_nothing_to_read_off_is_exit_1_and_no_wheel_at_all_exit_2(station, tmp_path):
    part = miniprof_file(tmp_path / "part.whl", to_d_mm=60.0)
    code, out, err = station("gauge", part, "--out", tmp_path / "r.csv")
    assert code == 1
    assert "not measured: half a wheel" in out
    assert err.count("\n") == 1
    assert (tmp_path / "r.csv").read_text().count("\n") == 2
    nonsense = tmp_path / "x.whl"
    nonsense.write_text("hello\n")
    code, out, err = station("gauge", nonsense)
    assert (code, out, err.count("\n")) == (2, "", 1)


def test_everything_asked_for_is_written(station, tmp_path, wheel):
    names = {
        "--out": "r.parquet",
        "--profiles": "points.csv",
        "--miniprof": "out.whl",
        "--plot": "profile.svg",
    }
    options = [word for option, name in names.items() for word in (option, tmp_path / name)]
    code, _, err = station("gauge", wheel, *options)
    assert (code, err) == (0, "")
    assert all((tmp_path / name).stat().st_size > 500 for name in names.values())


@pytest.mark.parametrize(
    ("option", "name", "match"),
    [
        ("--out", "r.txt", ".json, .csv, .parquet"),
        ("--profiles", "p.json", ".csv, .parquet"),
        ("--plot", "absent/p.svg", "no folder"),
        ("--miniprof", "wheel.whl", "is read and cannot be written"),
        ("--config", "absent.toml", "no such settings file"),
        ("--reference", "S1003", "S1002, LMA"),
    ],
)
def test_what_cannot_be_written_or_used_is_refused_before_the_work(
    station, tmp_path, wheel, option, name, match
):
    value = name if option == "--reference" else tmp_path / name
    before = wheel.read_bytes()
    code, out, err = station("gauge", wheel, option, value)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert match in err
    assert wheel.read_bytes() == before


def test_alarms_are_those_of_the_stations_settings(station, tmp_path, wheel):
    (tmp_path / "station.toml").write_text(CONFIG)
    config = ("--config", tmp_path / "station.toml")
    document = json.loads(station("gauge", wheel, *config, "--json")[1])
    assert document["wheels"][0]["tread_wear"]["alarm"] == "alarm"
    assert document["regime"] == "practice, changed"
    document = json.loads(station("gauge", wheel, "--json")[1])
    assert document["wheels"][0]["tread_wear"]["alarm"] == "none"


def test_a_new_wheel_is_registered_shown_and_counted_from(station, tmp_path, wheel):
    new = miniprof_file(tmp_path / "new.whl", worn_mm=0.4)
    registered = tmp_path / "new.json"
    code, out, _ = station("reference", "register", new, "--name", "fleet 7", "--out", registered)
    assert code == 0
    assert "flange_height 28.400" in out
    code, shown, _ = station("reference", "show", registered)
    assert (code, shown) == (0, out)
    assert "32.900" in station("reference", "show", "LMA")[1]
    document = json.loads(station("gauge", wheel, "--reference", registered, "--json")[1])
    assert document["reference"] == "fleet 7"
    assert document["wheels"][0]["tread_wear"]["value"] == pytest.approx(0.6, abs=2e-3)


def test_results_are_written_once_more_in_any_form(station, tmp_path, wheel):
    station("gauge", wheel, "--out", tmp_path / "r.json", "--plot", tmp_path / "a.svg")
    code, out, err = station(
        "results", tmp_path / "r.json", "--plot", tmp_path / "b.svg", "--out", tmp_path / "r.csv"
    )
    assert (code, err) == (0, "")
    assert "flange_height 29.00" in out
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert station("results", tmp_path / "r.json", "--out", tmp_path / "r.json")[0] == 2


@pytest.fixture(scope="module")
def picture(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    truth = WheelTruth(tread_wear_mm=2.0)
    (view,) = views_of(truth, (0.0,), np.random.default_rng(3), seed=4)
    cv2.imwrite(str(folder / "wheel.png"), view)
    true_calibration().write(folder / "calibration.json")
    return folder


def test_measure_writes_the_same_files_as_gauge(station, picture, tmp_path):
    (tmp_path / "station.toml").write_text(CONFIG)
    code, out, err = station(
        "measure", picture / "wheel.png", "--calibration", picture / "calibration.json",
        "--out", tmp_path / "r.parquet", "--profiles", tmp_path / "points.parquet",
        "--miniprof", tmp_path / "out.whl", "--plot", tmp_path / "drawings",
        "--config", tmp_path / "station.toml",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "tread_wear alarm" in out
    assert [path.name for path in (tmp_path / "drawings").iterdir()] == ["wheel-0.svg"]
    document = json.loads(station("gauge", tmp_path / "out.whl", "--json")[1])
    # Half a millimetre's mean is read again as a point: noise of 0.01 mm, smoothed over less.
    assert document["wheels"][0]["tread_wear"]["value"] == pytest.approx(2.0, abs=0.05)
