"""The driver with a camera that is not ours: Aravis' own GigE Vision simulator, on the network.

Unlike `Fake_1` it has a control channel, a heartbeat and packets; unlike our simulated camera it
sends no test packets, sends nothing again, and goes on counting when its stream is opened.  It
listens at the address of the loopback interface alone.
"""

import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest
from capture_rig import capture_of, is_idle, plan_for, sensor_at, wait_for

from station.capture import CaptureState
from station.recording import EventKind, frames, info, verify

ADDRESS = "127.0.0.1"
BE_A_CAMERA = """
import sys
from station.capture.aravis import Aravis
camera = Aravis.GvFakeCamera(
    interface_name="lo", serial_number="GV01", gvsp_lost_ratio=float(sys.argv[1])
)
print(camera.is_running(), flush=True)
sys.stdin.read()
"""


@contextmanager
def aravis_camera(lost_packets=0.0):
    with subprocess.Popen(
        [sys.executable, "-c", BE_A_CAMERA, str(lost_packets)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            if process.stdout.readline() != "True\n":
                pytest.skip(f"Aravis' GigE Vision camera cannot listen at {ADDRESS}")
            yield
        finally:
            process.kill()


def record(tmp_path, count):
    """Record so many frames in free run; return the report and the file."""
    path = tmp_path / "a.mcap"
    settings = sensor_at(ADDRESS, trigger="free", frame_rate_hz=25.0, ring_slots=48)
    with capture_of(settings, tmp_path) as (client, _):
        status = wait_for(client, is_idle)
        # It sends no test packets, so the size asked for is taken and said not to be proved.
        assert "sends no test packets" in status.warnings[0]
        client.arm(plan_for(path, "free", frames=count))
        wait_for(client, lambda status: status.state is CaptureState.RECORDED)
        return client.finish(), path


def assert_each_shows_the_pattern_moved_on(found):
    """Check that from one frame to the next the pattern goes a pixel to the left."""
    for before, after in zip(found, found[1:], strict=False):
        step = after.frame_id - before.frame_id
        np.testing.assert_array_equal(after.picture[:, :-step], before.picture[:, step:])


def test_camera_of_other_hands_is_recorded_frame_by_frame(tmp_path):
    with aravis_camera():
        report, path = record(tmp_path, 20)
    assert (report.recorded, report.lost, report.refused, report.repeated) == (20, 0, 0, 0)
    assert verify(path).ok
    found = list(frames(path))
    assert [frame.frame_id - found[0].frame_id for frame in found] == list(range(20))
    assert_each_shows_the_pattern_moved_on(found)
    assert info(path).metadata["camera"]["serial"] == "GV01"
    # It counts from 65400 on: whether something came before cannot be told, and that is said.
    assert EventKind.COUNTER_OFFSET in {event.kind for event in report.events}


def test_packets_that_are_lost_for_good_cost_frames_and_each_is_accounted_for(tmp_path):
    with aravis_camera(lost_packets=0.0001):
        report, path = record(tmp_path, 60)
    # 2868 packets of 1500 bytes a frame: a quarter of the frames lack one, 15 of 60, sigma 3.4.
    assert 0 < report.refused + report.lost < 35
    assert report.recorded + report.refused + report.lost == 60
    assert not report.complete
    assert verify(path).frames == report.recorded
    assert_each_shows_the_pattern_moved_on(list(frames(path)))
