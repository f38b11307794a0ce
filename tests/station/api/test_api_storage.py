"""Space on the disk as callers see it: a pass or session that would not fit is a 507 with numbers.

The disk is a double here; a real one fills up in the tests of the service.
"""

import shutil
from collections import namedtuple

import pytest

from station.capture import CaptureReport
from station.operations import utc_now
from station.recording import Rotation
from station.store import Recording, the

Usage = namedtuple("Usage", "total used free")  # noqa: PYI024  as shutil returns it


@pytest.fixture
def free(monkeypatch):
    """Set how many bytes are free."""

    def say(size_bytes):
        monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**12, 0, size_bytes))

    return say


# 1000 frames of 2048 x 1088 bytes and 512 around each, of two sensors, and 1 GB kept free.
NEEDED = 2 * 1000 * (2048 * 1088 + 512) + 10**9


def test_pass_that_would_not_fit_is_507_and_leaves_no_trace(free, served, call):
    free(NEEDED - 1)
    reply = call.put("/v1/passes/p1", json={})
    assert reply.status_code == 507
    assert reply.headers["content-type"] == "application/problem+json"
    detail = reply.json()["detail"]
    assert "the longest pass needs 5.46 GB free" in detail
    assert "left 1000 frames, 2.23 GB" in detail
    assert "\n" not in detail
    assert call.get("/v1/passes/p1").status_code == 404
    assert not served.captures["left"].plans
    free(NEEDED)
    assert call.put("/v1/passes/p1", json={}).status_code == 201


def test_pass_that_runs_is_told_to_a_caller_though_the_disk_is_full_by_now(free, call):
    assert call.put("/v1/passes/p1", json={}).status_code == 201
    free(0)
    assert call.put("/v1/passes/p1", json={}).status_code == 200


def test_session_that_would_not_fit_is_507_and_leaves_no_trace(free, call):
    order = {"sensor": "left", "target": "dots:7x8:12"}
    free(10**9)
    reply = call.put("/v1/calibration-sessions/s1", json=order)
    assert reply.status_code == 507
    assert "a calibration session needs 1.45 GB free" in reply.json()["detail"]
    assert call.get("/v1/calibration-sessions/s1").status_code == 404
    free(10**10)
    assert call.put("/v1/calibration-sessions/s1", json=order).status_code == 201


def test_a_pass_changes_files_every_minute_and_a_session_does_not(served, call):
    call.put("/v1/passes/p1", json={})
    call.post("/v1/passes/p1/finish", json={"axles": 4})
    call.put("/v1/calibration-sessions/s1", json={"sensor": "left", "target": "dots:7x8:12"})
    of_pass, of_session = served.captures["left"].plans
    assert of_pass.rotation == Rotation(seconds=60.0)
    assert of_session.rotation == Rotation()
    assert of_pass.reserve_bytes == 100_000_000


def test_recording_says_in_how_many_files_it_is_and_that_it_was_deleted(served, call, monkeypatch):
    finish = served.captures["left"].finish

    def in_two_files(expected_frames=None):
        report = finish(expected_frames)
        paths = [report.path, report.path.with_name("left.0002.mcap")]
        return CaptureReport.from_json({**report.to_json(), "paths": map(str, paths)})

    monkeypatch.setattr(served.captures["left"], "finish", in_two_files)
    call.put("/v1/passes/p1", json={})
    left, right = call.post("/v1/passes/p1/finish", json={"axles": 4}).json()["recordings"]
    assert (left["files"], right["files"]) == (2, 1)
    assert left["deleted_at"] is None
    with served.store.change() as session:
        row = the(session, Recording, left["id"])
        row.deleted_at, row.deleted_why = utc_now(), "older than keep_days = 3"
    found = call.get(f"/v1/recordings/{left['id']}").json()
    assert found["deleted_at"] is not None
    order = {"sensor": "left", "recordings": [left["id"]], "target": "dots:7x8:12"}
    reply = call.post("/v1/calibrations", json=order)
    assert reply.status_code == 409
    assert "was deleted on" in reply.json()["detail"]
    assert "keep_days = 3" in reply.json()["detail"]
