"""Shows measurements in the forms of other programs: the figures of the JSON, no other."""

import csv
import io
from datetime import UTC, datetime

import duckdb
import pytest

from measure import parse_profile_text
from station.store import (
    AxleWheel,
    Calibration,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    Recording,
)
from station.store.measured import add_measurements

PLACE = "/v1/measurements"
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
ROWS = 5
# A flange back, a tip and a tread, in the frame of profiles: as much as MiniProf asks for.
PROFILE = {
    "d_mm": [float(d) for d in range(0, 130, 2)],
    "h_mm": [float(28 - (d - 16) ** 2 / 20 if d < 36 else 8 - d / 20) for d in range(0, 130, 2)],
    "sigma_mm": [0.01] * 65,
}


def a_wheel(frame):
    reading = {"value": 28.0 + frame / 8, "u95": 0.05, "status": "ok", "alarm": "none"}
    measured = {"flange_height": reading, "profile": PROFILE, "reason": None}
    blind = {"profile": None, "reason": "no stripe, only rail; dark"}
    return {
        "source": "left.mcap",
        "sensor": "left",
        "frame": frame,
        "time": "2026-07-01T12:00:00Z",
        "quality": {"points": 900},
        **(blind if frame == ROWS else measured),
    }


@pytest.fixture
def measured(served):
    with served.store.change() as session:
        session.add(Pass(id="p1", state=PassState.DONE, opened_at=NOON))
        session.add(
            Calibration(
                id="c1",
                state=CalibrationState.READY,
                sensor="left",
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=NOON,
                job_id="j",
            )
        )
        session.flush()
        session.add(
            Recording(
                id="r1", sensor="left", pass_id="p1", path="x", opened_at=NOON, recovered=False
            )
        )
        session.flush()
        rows = [
            Measurement(
                recording_id="r1",
                frame=frame,
                calibration_id="c1",
                sensor="left",
                pass_id="p1",
                reference="S1002",
                software="none",
                measured_at=NOON,
                wheel=a_wheel(frame),
            )
            for frame in range(1, ROWS + 1)
        ]
        add_measurements(session, rows)
        session.add(
            AxleWheel(
                pass_id="p1",
                place=1,
                side="left",
                number=7,
                placing="certain",
                measurement_id=rows[0].id,
                others={"measurements": []},
                wheelset="ws-7",
                jumps={},
                back_to_back={"value": 1360.5, "u95": 0.2, "status": "ok", "alarm": "none"},
            )
        )
        return [row.id for row in rows]


def rows_of_csv(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_a_table_says_what_the_json_says(measured, call):
    reply = call.get(PLACE, params={"format": "csv"}).raise_for_status()
    assert reply.headers["content-type"].startswith("text/csv")
    rows = rows_of_csv(reply.text)
    told = call.get(PLACE).json()["measurements"]
    assert [int(row["id"]) for row in rows] == measured
    assert [float(row["flange_height"]) for row in rows[:-1]] == [
        each["wheel"]["flange_height"]["value"] for each in told[:-1]
    ]
    assert (rows[-1]["flange_height"], rows[-1]["reason"]) == ("", "no stripe, only rail; dark")
    first = rows[0]
    assert (first["recording"], first["calibration"], first["pass"]) == ("r1", "c1", "p1")
    assert (first["axle"], first["wheelset"], first["back_to_back"]) == ("7", "ws-7", "1360.5")
    assert (rows[1]["axle"], rows[1]["back_to_back"]) == ("", "")


def test_parquet_has_the_same_rows_with_their_types(measured, call, tmp_path):
    reply = call.get(PLACE, headers={"Accept": "application/vnd.apache.parquet"})
    (tmp_path / "table.parquet").write_bytes(reply.raise_for_status().content)
    with duckdb.connect() as database:
        table = database.read_parquet(str(tmp_path / "table.parquet"))
        found = table.select("id, flange_height, epoch(measured_at)").fetchall()
    assert [row[0] for row in found] == measured
    assert found[0][1] == 28.125
    assert found[0][2] == NOON.timestamp()


def test_a_table_comes_page_by_page_by_its_links(measured, call):
    found, there = [], f"{PLACE}?format=csv&limit=2&pass=p1"
    pages = 0
    while there is not None:
        reply = call.get(there).raise_for_status()
        found += [int(row["id"]) for row in rows_of_csv(reply.text)]
        there = reply.links.get("next", {}).get("url")
        pages += 1
    assert found == measured
    assert pages == 3


@pytest.mark.usefixtures("measured")
def test_what_a_call_accepts_chooses_the_form_unless_it_names_one(call):
    for accept, media in (
        ("text/csv", "text/csv"),
        ("application/json, text/csv", "application/json"),
        ("*/*", "application/json"),
        ("", "application/json"),
    ):
        reply = call.get(PLACE, headers={"Accept": accept})
        assert reply.headers["content-type"].startswith(media)
    named = call.get(PLACE, params={"format": "json"}, headers={"Accept": "text/csv"})
    assert named.headers["content-type"] == "application/json"
    assert call.get(PLACE, params={"format": "xlsx"}).status_code == 422


def test_a_profile_is_fetched_as_a_miniprof_file(measured, call):
    reply = call.get(f"{PLACE}/{measured[0]}/miniprof").raise_for_status()
    assert reply.headers["content-disposition"].endswith(f'"measurement-{measured[0]}.whl"')
    found = parse_profile_text(reply.text)
    assert found.header["WheelID"] == "ws-7"
    assert len(found.profile.d_mm) == len(PROFILE["d_mm"])


def test_a_wheel_that_could_not_be_measured_has_no_profile_to_fetch(measured, call):
    reply = call.get(f"{PLACE}/{measured[-1]}/miniprof")
    assert reply.status_code == 404
    assert "no stripe, only rail; dark" in reply.json()["detail"]
