"""The packet size is tried before frames depend on it."""

import pytest
from capture_rig import (
    assert_served,
    capture_of,
    is_idle,
    plan_for,
    sensor_at,
    small_camera,
    wait_for,
)

from station.capture.packet_size import fitting
from station.recording import EventKind, info
from station.simulated import Faults

ADDRESS = "127.20.1.1"


@pytest.mark.parametrize("path_bytes", [9000, 1500, 1400, 576])
def test_largest_usual_size_that_passes_is_used(path_bytes):
    size = fitting(9000, lambda asked: asked <= path_bytes)
    assert (size.used, size.proved) == (path_bytes, True)
    assert (size.warning is None) == (path_bytes == 9000)


def test_camera_that_sends_no_test_packets_keeps_the_size_and_is_warned_of():
    size = fitting(9000, lambda _: False)
    assert (size.used, size.proved) == (9000, False)
    assert "set packet_size = 1500" in size.warning


def test_switch_without_jumbo_frames_costs_a_warning_and_no_frame(tmp_path):
    path = tmp_path / "a.mcap"
    settings = sensor_at(ADDRESS, packet_size=9000)
    with (
        small_camera(ADDRESS, faults=Faults(path_bytes=1500)) as camera,
        capture_of(settings, tmp_path) as (client, _),
    ):
        status = wait_for(client, is_idle)
        assert status.camera["packet_size"] == "1500"
        client.arm(plan_for(path))
        for _ in range(5):
            assert camera.trigger_line1()
        report = client.finish(5)
    assert report.complete
    (event,) = [e for e in report.events if e.kind is EventKind.PACKET_SIZE]
    assert "packets of 9000 bytes do not come through, 1500 are used" in event.detail
    assert_served(path, 0, range(1, 6))
    assert "jumbo" in status.warnings[0]
    assert info(path).sensors[0].frames == 5
