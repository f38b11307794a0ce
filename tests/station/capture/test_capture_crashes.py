"""What is left when a process dies or the camera goes: nothing that another holds is lost."""

import contextlib
import os
import resource
import signal
import time

import pytest
from capture_rig import (
    PATIENCE_S,
    assert_served,
    capture_of,
    is_idle,
    is_running,
    plan_for,
    recorder_of,
    sensor_at,
    small_camera,
    wait_for,
    wait_until,
)

from station.capture import CaptureState
from station.errors import CameraLost, CameraUnreachable
from station.recording import EventKind, active_path, events, frames, recover, verify


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def fire(camera, count):
    for _ in range(count):
        assert camera.trigger_line1()
        time.sleep(0.01)


def kinds(recorded):
    return {event.kind for event in recorded}


def test_killed_recorder_is_replaced_and_no_frame_is_lost(tmp_path, path):
    address = "127.20.3.1"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address, ring_slots=200), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        for _ in range(2):
            fire(camera, 10)
            os.kill(recorder_of(process), signal.SIGKILL)
            fire(camera, 10)
        report = client.finish(expected_frames=40)
    assert (report.recorded, report.lost, report.complete) == (40, 0, True)
    assert_served(path, 0, range(1, 41))
    assert EventKind.RECORDER_RESTARTED in kinds(events(path))
    assert verify(path).ok


def test_recorder_killed_between_recordings_is_replaced(tmp_path, path):
    address = "127.20.3.2"
    with small_camera(address), capture_of(sensor_at(address), tmp_path) as (client, process):
        wait_for(client, is_idle)
        client.arm(plan_for(path, "software"))
        client.trigger()
        client.finish()
        recorder = recorder_of(process)
        os.kill(recorder, signal.SIGKILL)
        wait_until(lambda: not is_running(recorder))
        client.arm(plan_for(tmp_path / "b.mcap", "software"))
        client.trigger()
        assert client.finish().complete


def test_killed_capture_process_leaves_a_whole_recording_that_says_why_it_ends(tmp_path, path):
    address = "127.20.3.3"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, 10)
        wait_for(client, lambda status: status.recorded == 10)
        process.kill()
        wait_until(path.exists)
        with pytest.raises(CameraLost, match="does not answer"):
            type(client)(tmp_path / "s.sock", connect_timeout_s=0.1).status()
    assert_served(path, 0, range(1, 11))
    assert EventKind.CAPTURE_LOST in kinds(events(path))
    assert verify(path).ok


def test_both_killed_leave_a_recording_to_recover(tmp_path, path):
    address = "127.20.3.4"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, 10)
        wait_for(client, lambda status: status.recorded == 10)
        recorder = recorder_of(process)
        os.kill(recorder, signal.SIGSTOP)  # so that it cannot finish what the other leaves
        process.kill()
        os.kill(recorder, signal.SIGKILL)
        process.join()
        wait_until(lambda: not is_running(recorder))
    report = recover(active_path(path))
    assert report.frames == 10
    assert report.verified.ok
    assert_served(path, 0, range(1, 11))
    assert EventKind.RECOVERED in kinds(events(path))


def test_terminated_capture_process_finishes_its_recording(tmp_path, path):
    address = "127.20.3.5"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, 5)
        wait_for(client, lambda status: status.recorded == 5)
        process.terminate()
        process.join(PATIENCE_S)
        assert process.exitcode == 0
    assert EventKind.FINISHED in kinds(events(path))
    assert len(list(frames(path))) == 5
    assert not (tmp_path / "s.sock").exists()


def test_recorder_that_stalls_loses_what_the_ring_cannot_hold_and_says_so(tmp_path, path):
    address = "127.20.3.8"
    with (
        small_camera(address) as camera,
        capture_of(sensor_at(address, ring_slots=8), tmp_path) as (client, process),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, 5)
        wait_for(client, lambda status: status.recorded == 5)
        os.kill(recorder_of(process), signal.SIGSTOP)
        fire(camera, 30)
        wait_for(client, lambda status: status.ring_waiting == 8)
        time.sleep(1.0)  # the rest comes; who would count it as lost is stopped
        os.kill(recorder_of(process), signal.SIGCONT)
        fire(camera, 5)
        report = client.finish(expected_frames=40)
    assert report.recorded + report.lost + report.refused == 40
    assert 13 <= report.recorded < 40
    assert not report.complete
    assert EventKind.RING_FULL in kinds(events(path))
    ids = [frame.frame_id for frame in frames(path)]
    assert len(ids) == report.recorded
    assert verify(path).ok
    assert verify(path).lost == report.lost + report.refused


@pytest.fixture
def small_disk():
    """Let no file of this process's children grow beyond 2 MB, as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_full_disk_ends_the_recording_whole_and_the_capture_lives_on(tmp_path, path, small_disk):
    address = "127.20.3.9"
    with (
        small_camera(address) as camera,
        # The ring is no file of a disk, but the limit holds for it too.
        capture_of(sensor_at(address, ring_slots=24), tmp_path) as (client, _),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, 20)
        wait_for(client, lambda status: status.recorded == 20)
        fire(camera, 20)
        report = client.finish(expected_frames=40)
        client.arm(plan_for(tmp_path / "b.mcap"))
        fire(camera, 2)
        again = client.finish(expected_frames=2)
    assert report.recorded + report.lost == 40
    assert 20 <= report.recorded <= 26  # 77 kB each
    assert not report.complete
    assert EventKind.DISK_FULL in kinds(report.events)
    assert EventKind.DISK_FULL in kinds(events(path))
    assert_served(path, 0, range(1, report.recorded + 1))
    assert verify(path).ok
    assert again.complete


def test_camera_gone_and_back_goes_on_in_the_same_recording(tmp_path, path):
    address = "127.20.3.6"
    before, after = small_camera(address), small_camera(address)
    with contextlib.ExitStack() as until_the_end:
        until_the_end.callback(after.stop)
        client, _ = until_the_end.enter_context(capture_of(sensor_at(address), tmp_path))
        with before:
            wait_for(client, is_idle)
            client.arm(plan_for(path))
            fire(before, 5)
            wait_for(client, lambda status: status.recorded == 5)
        wait_for(client, lambda status: status.state is CaptureState.BLIND)
        after.start()
        wait_for(client, lambda status: status.state is CaptureState.RECORDING)
        fire(after, 4)
        wait_for(client, lambda status: status.recorded == 9)
        report = client.finish(expected_frames=9)
        assert is_idle(client.status())
    assert (report.recorded, report.complete) == (9, False)
    assert [frame.frame_id for frame in frames(path)] == list(range(1, 10))
    assert {EventKind.CAMERA_LOST, EventKind.CAMERA_BACK} <= kinds(events(path))
    assert verify(path).ok


def test_camera_that_never_answers_is_unreachable_and_is_found_when_it_comes(tmp_path, path):
    address = "127.20.3.7"
    camera = small_camera(address)
    with contextlib.ExitStack() as until_the_end:
        until_the_end.callback(camera.stop)
        client, _ = until_the_end.enter_context(capture_of(sensor_at(address), tmp_path))
        with pytest.raises(CameraUnreachable, match="no camera answers at 127.20.3.7"):
            client.arm(plan_for(path))
        assert client.status().state is CaptureState.UNAVAILABLE
        camera.start()
        assert wait_for(client, is_idle).problem is None
    assert list(tmp_path.glob("*.mcap*")) == []
