"""Shows the whole text of `/metrics`: that it parses, is named as is usual, is in the handbook, and
comes whatever part of the station fails.  The figures behind it are shown where they are made."""

import json
import re
from datetime import timedelta
from pathlib import Path

import pytest
from prometheus_client.parser import text_string_to_metric_families

from station.operations import utc_now
from station.processes.tally import write_tally
from station.store import (
    STATION,
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    activate,
    add_job,
)

HANDBOOK = Path(__file__).resolve().parents[3] / "station" / "handbook"
ALARMS = (HANDBOOK / "alarms.md").read_text(encoding="utf-8")
DOCUMENT = {
    "sensor": "left", "created": "2026-07-01T12:00:00Z", "software": "treadline 0",
    "method": "joint",
    "camera": {"fx": 1, "fy": 1, "cx": 0, "cy": 0, "width": 8, "height": 8},
    "plane": {"a": 0, "b": 0, "c": -1, "d": 500}, "plane_covariance": [[0.0] * 4] * 4,
    "rms": {"dots_px": 0.125, "stripe_px": 0.25}, "poses": [], "quality": {}, "options": {},
    "inputs": [],
}  # fmt: skip


def families(client):
    answer = client.get("/metrics")
    assert answer.status_code == 200
    return {each.name: each for each in text_string_to_metric_families(answer.text)}


def value(found, name, /, **labels):
    """The one sample of a name that bears the labels."""
    samples = [
        sample.value
        for family in found.values()
        for sample in family.samples
        if sample.name == name and labels.items() <= sample.labels.items()
    ]
    (only,) = samples
    return only


def own(found):
    return {name: family for name, family in found.items() if name.startswith("station_")}


def test_every_name_and_unit_is_as_prometheus_has_them(call):
    """What `promtool check metrics` looks at."""
    call.get("/v1/passes/none")
    for name, family in own(families(call)).items():
        assert re.fullmatch(r"station(_[a-z]+)+", name), name
        assert family.documentation.endswith("."), name
        assert family.type in {"gauge", "counter", "histogram"}
        # The parser takes `_total` off a counter; of another kind it would be there still.
        assert not name.endswith(("_total", "_count", "_sum", "_bucket")), name
        other_units = r"(ms|us|ns|mm|um|px|ppm|percent|hours?|minutes?|days?|[kmg]b|milli\w+)"
        assert not re.search(rf"_{other_units}(_|$)", name), name
        for sample in family.samples:
            assert all(re.fullmatch(r"[a-z]+", label) for label in sample.labels), name
            assert family.type != "counter" or sample.name == f"{name}_total"


def test_the_handbook_lists_them_all_and_no_other(served, call, busy):
    """With their labels, where this station has a value to show them by."""
    measured(served, finished_at=busy)
    families(call)
    row = r"^\| `(station_\w+)` \| ([a-z, ]*) \| ([^|]+) \|$"
    shown = {name: (labels, text) for name, labels, text in re.findall(row, ALARMS, re.MULTILINE)}
    found = {
        name + ("_total" if family.type == "counter" else ""): family
        for name, family in own(families(call)).items()
    }
    assert {name: text for name, (_, text) in shown.items()} == {
        name: family.documentation for name, family in found.items()
    }
    for name, family in found.items():
        for sample in family.samples:
            assert ", ".join(sorted(sample.labels.keys() - {"le"})) == shown[name][0], name


def test_ids_from_outside_never_become_labels(served, call):
    call.put("/v1/passes/the-name-of-a-pass", json={}, headers={"X-Request-Id": "the-id"})
    call.get("/v1/jobs/the-name-of-a-job")
    call.get("/the/name/of/nowhere")
    call.request("BREW", "/v1/passes")
    text = call.get("/metrics").text
    assert "the-" not in text
    assert "nowhere" not in text
    assert "BREW" not in text


def test_a_part_that_fails_is_counted_and_the_others_are_told(call, monkeypatch):
    def explode(_self):
        raise OSError("no such disk")

    monkeypatch.setattr("station.api.host_metrics.HostCollector.collect", explode)
    families(call)
    found = families(call)
    assert value(found, "station_collect_errors_total", part="host") == 2.0
    assert value(found, "station_collect_errors_total", part="store") == 0.0
    assert "station_disk_free_bytes" not in found
    assert value(found, "station_sensor_up", sensor="left") == 1.0


@pytest.fixture
def busy(served):
    """A station with a calibration in force, a measured pass, waiting jobs and files."""
    now = utc_now()
    with served.store.change() as session:
        calibration = Calibration(
            id="c1", state=CalibrationState.READY, sensor="left", target="dots:7x8:12",
            method="joint", recording_ids={"recordings": [], "laser_off": []},
            created_at=now - timedelta(days=2), job_id="j0", passed=True,
            document=json.dumps(DOCUMENT),
        )  # fmt: skip
        session.add(calibration)
        session.flush()
        activate(session, calibration, sensor="left", seen=None, by=STATION, at=now)
        add_job(session, "j1", JobKind.MEASURE, "p2", at=now - timedelta(seconds=90))
        add_job(session, "j2", JobKind.MEASURE, "p3", at=now - timedelta(seconds=30))
    folder = served.layout.root / "recordings"
    folder.mkdir()
    (folder / "one.mcap").write_bytes(b"x" * 4096)
    served.layout.backup_note.write_text("backup")
    write_tally(served.layout.restarts_note, {"worker": 3})
    return now


def measured(served, *, finished_at):
    """A pass of two wheels, one of them unmeasurable, whose measuring ended just now."""
    now = utc_now()
    with served.store.change() as session:
        session.add(
            Job(
                id="m1", kind=JobKind.MEASURE, subject="p1", state=JobState.DONE, progress=1.0,
                doing="done", created_at=finished_at, started_at=now - timedelta(seconds=1),
                ended_at=now,
            )
        )  # fmt: skip
        session.add(
            Pass(
                id="p1", state=PassState.DONE, opened_at=finished_at, finished_at=finished_at,
                job_id="m1",
            )
        )  # fmt: skip
        session.flush()
        session.add(
            Recording(
                id="r1", sensor="left", pass_id="p1", path="p1.mcap", opened_at=finished_at,
                closed_at=now, calibration_id="c1", recorded=2, lost=1,
            )
        )  # fmt: skip
        session.flush()
        wheels = [{"quality": {"coverage": 0.75}}, {"quality": {}, "reason": "no stripe"}]
        session.add_all(
            Measurement(
                recording_id="r1", frame=frame, calibration_id="c1", sensor="left", pass_id="p1",
                reference="S1002", software="none", measured_at=now, wheel=wheel,
            )
            for frame, wheel in enumerate(wheels)
        )  # fmt: skip


def test_calibrations_work_disk_and_processes_are_told_in_base_units(served, call, busy):
    found = families(call)
    assert value(found, "station_calibration_rms_pixels", sensor="left", of="stripe") == 0.25
    assert value(found, "station_calibration_age_seconds", sensor="left") >= 2 * 86_400
    assert value(found, "station_jobs_waiting", kind="measure") == 2.0
    assert value(found, "station_jobs_oldest_waiting_seconds", kind="measure") >= 90.0
    assert value(found, "station_recordings_bytes") == 4096.0
    assert value(found, "station_backup_age_seconds") >= 0.0
    assert value(found, "station_process_restarts_total", process="worker") == 3.0
    assert value(found, "station_store_bytes", file="store") > 0.0
    assert found["station_recordings_quota_bytes"].samples == []


def test_a_pass_that_was_measured_is_counted_once_with_what_came_of_it(served, call, busy):
    assert value(families(call), "station_pass_results_seconds_count") == 0.0
    measured(served, finished_at=busy - timedelta(seconds=3))
    families(call)
    found = families(call)
    assert value(found, "station_pass_results_seconds_count") == 1.0
    assert value(found, "station_pass_results_seconds_sum") >= 3.0
    assert value(found, "station_wheel_measuring_seconds_sum") == pytest.approx(0.5)
    assert value(found, "station_last_pass_wheels", sensor="left", outcome="unmeasurable") == 1.0
    assert value(found, "station_last_pass_coverage_ratio", sensor="left") == 0.75
    assert value(found, "station_recorded_frames", sensor="left", fate="lost") == 1.0


def test_what_the_captures_count_is_a_counter_of_each_sensor(served, call):
    served.captures["right"].broken = "no camera answers at 127.0.0.3"
    served.captures["left"].lost = 2
    found = families(call)
    assert value(found, "station_sensor_up", sensor="left") == 1.0
    assert value(found, "station_sensor_up", sensor="right") == 0.0
    assert value(found, "station_sensor_frames_total", sensor="left", fate="lost") == 2.0
    assert value(found, "station_ready") == 0.0
    assert value(found, "station_alarms", kind="capture_silent", severity="critical") == 1.0
