"""Recordings become one table: a row a wheel, a damaged recording named, the others done.

That the readings are those of the live pass is shown in tests/system.
"""

import csv
import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

import duckdb
import numpy as np
import pytest
from wheel_recordings import FILE_FOR_EACH_FRAME, record, true_calibration, views_of

import station.pipeline.cores as pipeline_cores
from measure import Side
from station.cli.main import build_app, run
from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.pipeline import measure_sources
from station.replay import replay_recordings
from station.scenes import WheelTruth

CALIBRATION = true_calibration()
EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("recordings")


@pytest.fixture(scope="module")
def train():
    """Return two views of each of three wheels; the last wheel is not to be seen."""
    rng = np.random.default_rng(5)
    seen = [
        views_of(WheelTruth(tread_wear_mm=wear_mm), (-20.0, 0.0), rng, seed=int(wear_mm))
        for wear_mm in (1.0, 3.0)
    ]
    return [*seen, [np.zeros_like(view) for view in seen[0]]]


@pytest.fixture(scope="module")
def passes(folder, train):
    """Return two recordings of the same name in folders of their own."""
    paths = [folder / name / "left.mcap" for name in ("monday", "tuesday")]
    for path, shown in zip(paths, (train, train[1:]), strict=True):
        path.parent.mkdir()
        record(path, shown)
    return paths


@pytest.fixture(scope="module")
def damaged(folder, train):
    """Return a recording that is sound for longer than what is read at a time."""
    (path,) = record(folder / "damaged.mcap", train * 2)
    content = bytearray(path.read_bytes())
    content[len(content) * 11 // 12] ^= 1
    path.write_bytes(content)
    return path


def rows_of(path):
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_a_table_has_a_row_a_wheel_measured_or_with_a_reason(passes, tmp_path):
    report = replay_recordings(passes, CALIBRATION, tmp_path / "r.csv")
    assert (report.recordings, report.frames, report.wheels, report.measured) == (2, 10, 5, 3)
    rows = rows_of(report.out)
    assert [row["recording"] for row in rows] == ["monday/left.mcap"] * 3 + [
        "tuesday/left.mcap"
    ] * 2
    assert [bool(row["tread_wear"]) for row in rows] == [True, True, False, True, False]
    assert [bool(row["reason"]) for row in rows] == [False, False, True, False, True]
    assert {row["calibration"] for row in rows} == {CALIBRATION.fingerprint}
    assert rows[0]["time"].startswith("2025-10-09T08:53:20")
    assert [row["frame"] in {"1", "2"} for row in rows] == [True, False, False, True, False]


def test_numbers_in_every_table_are_those_of_measuring_to_the_last_bit(passes, tmp_path):
    measured = measure_sources(passes[:1], CALIBRATION).wheels
    for name in ("r.csv", "r.json"):
        replay_recordings(passes[:1], CALIBRATION, tmp_path / name)
    rows = rows_of(tmp_path / "r.csv")
    wheels = MeasurementDocument.read(tmp_path / "r.json").wheels
    assert wheels == measured
    for row, wheel in zip(rows, measured, strict=True):
        for quantity, reading in wheel.readings.items():
            for ending, value in (("", reading.value), ("_u95", reading.u95)):
                text = row[quantity.value + ending]
                assert (float(text) if text else None) == value


def test_wheel_whose_frames_lie_in_several_files_is_one_row_and_reads_the_same(train, tmp_path):
    (whole,) = record(tmp_path / "whole.mcap", train)
    parts = record(tmp_path / "parts.mcap", train, rotation=FILE_FOR_EACH_FRAME)
    assert len(parts) == 6
    found = []
    for given in ([whole], [parts[0]], reversed(parts)):
        report = replay_recordings(list(given), CALIBRATION, tmp_path / "r.json")
        assert (report.recordings, report.frames, report.wheels) == (1, 6, 3)
        wheels = MeasurementDocument.read(report.out).wheels
        found.append([wheel.model_dump(exclude={"source"}) for wheel in wheels])
    assert found[1] == found[2] == found[0]
    assert [wheel["frames"] for wheel in found[0]] == [(1, 2), (3, 4), (5, 6)]


@pytest.mark.slow
def test_the_work_of_all_cores_is_that_of_one_to_the_last_bit(passes, tmp_path, monkeypatch):
    alone = replay_recordings(passes, CALIBRATION, tmp_path / "alone.json").out
    monkeypatch.setattr(pipeline_cores, "_START_S", -1e9)
    on_all = replay_recordings(passes, CALIBRATION, tmp_path / "all.json").out
    found = [MeasurementDocument.read(path).wheels for path in (alone, on_all)]
    assert found[0] == found[1]


def test_a_damaged_recording_is_named_and_the_rest_is_done(passes, damaged, tmp_path):
    report = replay_recordings([damaged, *passes], CALIBRATION, tmp_path / "r.csv")
    (refusal,) = report.refused
    assert refusal.recording == "damaged.mcap"
    assert "checksum" in refusal.reason
    assert (report.recordings, report.wheels) == (2, 5)
    # Nor is what stood before the damage in the table: part of a train passes for all of it.
    assert "damaged.mcap" not in {row["recording"] for row in rows_of(report.out)}


def test_what_is_no_recording_or_of_another_sensor_is_named_too(passes, train, tmp_path):
    (other,) = record(tmp_path / "right.mcap", train[:1], sensor="right")
    text = tmp_path / "text.mcap"
    text.write_text("no recording")
    report = replay_recordings([text, other, passes[1]], CALIBRATION, tmp_path / "r.csv")
    reasons = {refusal.recording: refusal.reason for refusal in report.refused}
    assert "not MCAP" in reasons["text.mcap"]
    assert "of sensor right but the calibration is of left" in reasons["right.mcap"]
    assert report.recordings == 1


def station(*arguments):
    return run(build_app("replay"), ["replay", *map(str, arguments)])


@pytest.fixture
def calibration_file(tmp_path):
    CALIBRATION.write(tmp_path / "calibration.json")
    return tmp_path / "calibration.json"


def test_command_tells_by_its_exit_code_whether_all_is_in_the_table(
    passes, damaged, calibration_file, tmp_path, capsys
):
    arguments = ["--calibration", calibration_file, "--out", tmp_path / "r.json", "--json"]
    assert station(passes[1], *arguments) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["recordings"], said["wheels"], said["measured"]) == (1, 2, 1)
    assert station(passes[1], damaged, *arguments) == 1
    captured = capsys.readouterr()
    assert json.loads(captured.out)["refused"][0]["recording"] == "damaged.mcap"
    assert captured.err.startswith("station: 1 of 2 recordings are not in the table")
    assert captured.err.count("\n") == 1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"sources": [Path("picture.png")]}, "not a recording"),
        ({"out": Path("results.xlsx")}, r"allowed: a name that ends in \.json, \.csv, \.parquet"),
        ({"out": Path("nowhere/at/all.csv")}, "cannot be written"),
        ({"reference": "S1003"}, "S1002, LMA"),
    ],
    ids=["a picture", "kind of table", "no folder", "reference"],
)
def test_what_cannot_be_used_is_refused_before_any_work(passes, tmp_path, given, message):
    usual = {"sources": passes, "calibration": CALIBRATION, "out": tmp_path / "r.csv"}
    with pytest.raises(InputUnusable, match=message):
        replay_recordings(**{**usual, **given})
    assert not list(tmp_path.iterdir())


def test_parquet_holds_the_table_with_its_types(passes, tmp_path):
    out = replay_recordings(passes, CALIBRATION, tmp_path / "r.parquet").out
    wheels = measure_sources(passes[:1], CALIBRATION).wheels
    columns = "tread_wear, frame, typeof(time), epoch_us(time)"
    found = duckdb.sql(f"SELECT {columns} FROM '{out}' LIMIT 3").fetchall()
    assert found == [
        (
            wheel.tread_wear.value,
            wheel.frame,
            "TIMESTAMP WITH TIME ZONE",
            (wheel.time - EPOCH) // timedelta(microseconds=1),
        )
        for wheel in wheels
    ]
    assert list(tmp_path.iterdir()) == [out]


@pytest.fixture(scope="module")
def both_sides(folder, train):
    """Return two passes, each seen by two sensors; of the second the right one saw one wheel."""
    paths = []
    for name, lost in (("first", 0), ("second", 1)):
        for sensor, shown in (("left", train[:2]), ("right", train[: 2 - lost])):
            path = folder / name / f"{sensor}.mcap"
            path.parent.mkdir(exist_ok=True)
            record(path, shown, sensor=sensor)
            paths.append(path)
    return paths


def placed(rows):
    return [(row["axle"], row["side"], row["placing"], row["reason"] == "") for row in rows]


def test_recordings_of_several_sensors_stand_pass_for_pass_axle_for_axle(both_sides, tmp_path):
    calibrations = [CALIBRATION, true_calibration("right")]
    sides = {side.value: side for side in Side}
    out = tmp_path / "both.csv"
    report = replay_recordings(both_sides, calibrations, out, sides=sides)
    assert (report.recordings, report.wheels, report.measured) == (4, 8, 7)
    assert report.frames == 14
    rows = rows_of(out)
    whole = [(n, side, "inferred", True) for n in "12" for side in ("left", "right")]
    assert placed(rows) == [*whole, *whole[:3], ("2", "right", "inferred", False)]
    prints = {one.sensor: one.fingerprint for one in calibrations}
    assert all(row["calibration"] == prints[row["sensor"]] for row in rows)
    # The same readings as of one sensor alone, to the last digit.
    replay_recordings(both_sides[:1], CALIBRATION, tmp_path / "one.csv")
    alone = [row["tread_wear"] for row in rows_of(tmp_path / "one.csv")]
    assert [row["tread_wear"] for row in rows[:4:2]] == alone


def test_a_sensor_whose_side_is_not_known_is_measured_and_put_on_no_axle(both_sides, tmp_path):
    calibrations = [CALIBRATION, true_calibration("right")]
    out = tmp_path / "both.csv"
    replay_recordings(both_sides[:2], calibrations, out, sides={"left": Side.LEFT})
    assert [row["axle"] for row in rows_of(out)] == ["1", "2", "", ""]


def test_a_recording_without_calibration_is_refused_and_the_others_stand(both_sides, tmp_path):
    calibrations = [CALIBRATION, true_calibration("middle")]
    report = replay_recordings(both_sides[:2], calibrations, tmp_path / "r.csv")
    assert (report.recordings, report.wheels) == (1, 2)
    assert "is of sensor right but the calibrations are of left, middle" in report.refused[0].reason
    with pytest.raises(InputUnusable, match="two calibrations of one sensor"):
        replay_recordings(both_sides, [CALIBRATION, CALIBRATION], tmp_path / "r.csv")
