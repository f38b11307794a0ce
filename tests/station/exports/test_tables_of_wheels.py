"""Readings and points as tables: every number is there, whatever the kind of file."""

import csv

import duckdb
import pytest
from profile_files import miniprof_file

from measure import Quantity
from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.exports import COLUMNS, check_table_name, check_target, table_writer, write_points
from station.pipeline import gauge_files


@pytest.fixture
def document(tmp_path):
    whole = miniprof_file(tmp_path / "whole.whl", {"Sh": "28.1"}, worn_mm=1.0)
    return gauge_files([whole, miniprof_file(tmp_path / "part.whl", to_d_mm=60.0)])


def rows_of(path):
    if path.suffix == ".parquet":
        found = duckdb.sql(f"select * from '{path}'")
        return [dict(zip(found.columns, row, strict=True)) for row in found.fetchall()]
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_row_a_wheel_has_value_u95_status_and_alarm_of_every_quantity(tmp_path, document, suffix):
    out = tmp_path / f"r{suffix}"
    table_writer(out)(out, document, document.wheels)
    measured, not_measured = rows_of(out)
    assert list(measured) == list(COLUMNS)
    for quantity, reading in document.wheels[0].readings.items():
        for ending, value in (("", reading.value), ("_u95", reading.u95)):
            kept = measured[quantity.value + ending]
            assert (None if kept in {"", None} else float(kept)) == value
        assert measured[f"{quantity.value}_status"] == reading.status
        assert measured[f"{quantity.value}_alarm"] == reading.alarm
    assert float(measured["header_flange_height"]) == 28.1
    assert measured["regime"] == "practice"
    assert not not_measured["tread_wear"]
    assert "half a wheel" in not_measured["reason"]


def test_results_json_is_the_same_as_the_document(tmp_path, document):
    out = tmp_path / "r.json"
    table_writer(out)(out, document, document.wheels)
    assert MeasurementDocument.read(out) == document


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_points_are_a_table_of_their_own_that_names_the_wheel(tmp_path, document, suffix):
    out = tmp_path / f"points{suffix}"
    write_points(out, document.wheels)
    rows = rows_of(out)
    profile = document.wheels[0].profile
    assert len(rows) == len(profile.d_mm)
    assert {int(row["wheel"]) for row in rows} == {1}
    for name in ("d_mm", "h_mm", "sigma_mm", "wear_mm"):
        found = [float(row[name]) if row[name] not in {"", None} else None for row in rows]
        assert found == list(getattr(profile, name))


def test_names_that_stand_for_no_table_are_refused(tmp_path):
    for name in ("r.txt", "r", "r.JSONL"):
        with pytest.raises(InputUnusable, match=r"\.json, \.csv, \.parquet"):
            table_writer(tmp_path / name)
    with pytest.raises(InputUnusable, match=r"--profiles .*\.csv, \.parquet"):
        check_table_name(tmp_path / "points.json", "--profiles")
    with pytest.raises(InputUnusable, match="no folder"):
        check_target(tmp_path / "absent" / "r.csv", "--out")


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".json"])
def test_a_folder_that_is_not_there_is_refused_in_one_line(tmp_path, document, suffix):
    out = tmp_path / "absent" / f"r{suffix}"
    with pytest.raises(InputUnusable, match="cannot be written"):
        table_writer(out)(out, document, document.wheels)


def test_every_quantity_has_its_columns():
    for quantity in Quantity:
        assert {quantity.value + end for end in ("", "_u95", "_status", "_alarm")} <= set(COLUMNS)
