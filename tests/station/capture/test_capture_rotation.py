"""Recordings in several files through the whole chain: no frame is lost where one follows another.

At small sizes and rates; what a slow disk does to full frames at 53 Hz is not shown.
"""

import os
import signal
import time

import numpy as np
import pytest
from capture_rig import (
    capture_of,
    is_idle,
    plan_for,
    recorder_of,
    sensor_at,
    served_pictures,
    small_camera,
    wait_for,
)

from station.operations import salvage_recording
from station.recording import (
    EventKind,
    Rotation,
    active_path,
    events,
    frames,
    info,
    parts_of,
    verify,
)

PICTURES = 16


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def fire(camera, count):
    for _ in range(count):
        assert camera.trigger_line1()
        time.sleep(0.005)


def ids_in(parts):
    return [frame.frame_id for part in parts for frame in frames(part)]


def assert_served(parts):
    pictures = served_pictures()
    for part in parts:
        for frame in frames(part):
            np.testing.assert_array_equal(frame.picture, pictures[(frame.frame_id - 1) % PICTURES])


def test_all_frames_are_in_the_files_that_the_report_names(tmp_path, path):
    address = "127.10.1.1"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address), tmp_path) as (client, _),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path, rotation=Rotation(seconds=0.2)))
        fire(camera, 200)
        report = client.finish(expected_frames=200)
        client.arm(plan_for(tmp_path / "b.mcap"))
        fire(camera, 2)
        one_file = client.finish(expected_frames=2)
    assert (report.recorded, report.complete) == (200, True)
    assert len(report.paths) >= 4
    assert report.paths == parts_of(path)
    assert f"200 frames of 200 triggered recorded in {len(report.paths)} files" in report.summary()
    assert ids_in(report.paths) == list(range(1, 201))
    assert_served(report.paths)
    assert all(verify(part).ok for part in report.paths)
    account = info(report.paths[-1]).metadata["accounting"]
    assert (account["recorded"], account["part"]) == ("200", str(len(report.paths)))
    assert one_file.paths == (tmp_path / "b.mcap",)


def test_recorders_killed_at_any_moment_of_the_change_lose_no_frame(tmp_path, path, rng):
    """A next file every 40 ms, and nine kills at random moments."""
    address, kills = "127.10.1.2", 9  # ten are the most that one recording bridges
    counts = rng.integers(30, 50, kills).tolist()
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address, ring_slots=400), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path, rotation=Rotation(seconds=0.04)))
        for count in counts:
            fire(camera, count)
            os.kill(recorder_of(process), signal.SIGKILL)
        fire(camera, 30)
        triggered = sum(counts) + 30
        report = client.finish(expected_frames=triggered)
    assert (report.recorded, report.lost, report.complete) == (triggered, 0, True)
    assert len(report.paths) >= 4
    assert ids_in(report.paths) == list(range(1, triggered + 1))
    assert_served(report.paths)
    found = {event.kind for part in report.paths for event in events(part)}
    assert EventKind.RECORDER_RESTARTED in found
    assert EventKind.RECOVERED not in found
    assert all(verify(part).ok for part in report.paths)


def test_salvage_takes_all_files_that_dead_processes_left(tmp_path, path):
    address = "127.10.1.3"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path, rotation=Rotation(seconds=0.1)))
        fire(camera, 60)
        wait_for(client, lambda status: status.recorded == 60)
        recorder = recorder_of(process)
        os.kill(recorder, signal.SIGSTOP)  # so that it cannot finish what the other leaves
        process.kill()
        os.kill(recorder, signal.SIGKILL)
        process.join()
        found = salvage_recording(path)
    assert found is not None
    assert (found.frames, found.files) == (60, len(parts_of(path)))
    assert found.files >= 2
    assert f"60 frames saved in {found.files} files" in found.summary
    assert ids_in(parts_of(path)) == list(range(1, 61))
    assert not any(active_path(part).exists() for part in parts_of(path))
