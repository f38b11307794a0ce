"""Shows that a recording whose capture process was killed is gone on with in a next file: numbered
on, said, and accounted for as one.  Who decides to do so is shown with the operations."""

import os
import signal
import time
from dataclasses import replace

import pytest
from capture_rig import (
    capture_of,
    is_idle,
    plan_for,
    recorder_of,
    sensor_at,
    small_camera,
    wait_for,
    wait_until,
)
from test_capture_crashes import fire

from station.capture import CaptureReport, Interruption
from station.recording import EventKind, events, frames, info, parts_of


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def killed_after(address, folder, camera, path, count):
    with capture_of(sensor_at(address), folder) as (client, process):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        fire(camera, count)
        wait_for(client, lambda status: status.recorded == count)
        process.kill()
        wait_until(path.exists)
        process.join()


def behind(path, count):
    return Interruption(files=1, frames=count, last_frame_id=count, since_ns=time.time_ns())


def test_another_process_goes_on_in_a_next_file_and_accounts_for_all(tmp_path, path):
    address = "127.38.0.2"
    with small_camera(address) as camera:
        killed_after(address, tmp_path, camera, path, 5)
        fire(camera, 2)  # nobody is there
        with capture_of(sensor_at(address), tmp_path) as (client, process):
            wait_for(client, is_idle)
            client.arm(replace(plan_for(path), goes_on=behind(path, 5)))
            fire(camera, 3)
            wait_for(client, lambda status: status.recorded == 3)
            os.kill(recorder_of(process), signal.SIGKILL)
            fire(camera, 1)
            report = client.finish(expected_frames=11)
    first, second = parts_of(path)
    assert report.paths == (first, second)
    assert [frame.frame_id for part in (first, second) for frame in frames(part)] == [*range(1, 10)]
    assert (report.recorded, report.lost, report.complete) == (9, 2, False)
    assert report.interrupted
    assert "gone on with after the capture process died" in report.summary()
    begins = [event for event in events(second) if event.kind is EventKind.CAPTURE_BACK]
    assert len(begins) == 1
    assert "after frame 5" in begins[0].detail
    assert info(second).metadata["accounting"]["recorded"] == "9"


def test_a_recording_that_was_gone_on_with_is_not_complete_though_no_frame_is_known_to_miss(path):
    event = behind(path, 5).event(time.time_ns())
    report = CaptureReport(path, None, 7, 0, 0, 0, 0, None, None, (event,))
    assert not report.complete
    assert report.interrupted


def test_an_interruption_that_cannot_be_is_refused():
    with pytest.raises(ValueError, match="negative"):
        Interruption(-1, 0, 0, 0)
    with pytest.raises(ValueError, match="frames are in a file"):
        Interruption(1, 3, 0, 0)
