"""Times of a camera with a wrong clock, through a real control channel and stream, are UTC.

Camera and receiver share this host's clock, so that the truth is known.
"""

import time

import numpy as np
import pytest
from capture_rig import capture_of, is_idle, plan_for, sensor_at, small_camera, wait_for

from station.recording import EventKind, frames, info
from station.simulated import DeviceClock, DeviceOptions

ADDRESS = "127.20.6.1"
SECOND = 1_000_000_000


def has_drift(status):
    # A busy host answers some of the questions too late to tell anything: then more are asked.
    return status.clock["clock_drift_ppm"] != ""


def record(tmp_path, clock, seconds, rate_hz=20, enough=lambda _: True):
    """Record triggers at known times; return those, the recording and the last status."""
    path = tmp_path / "a.mcap"
    given = []
    with (
        small_camera(ADDRESS, options=DeviceOptions(clock=clock)) as camera,
        capture_of(sensor_at(ADDRESS, exposure_us=1000.0), tmp_path) as (client, _),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        began_s = time.monotonic()
        while len(given) < seconds * rate_hz or not enough(client.status()):
            assert time.monotonic() - began_s < 60.0
            given.append(time.time_ns())
            assert camera.trigger_line1(given[-1])
            time.sleep(1.0 / rate_hz)
        status = client.status()
        report = client.finish(len(given))
    return given, path, status, report


@pytest.mark.parametrize("offset_s", [-1000])
def test_camera_that_is_off_and_drifts_comes_out_within_a_millisecond(tmp_path, offset_s):
    clock = DeviceClock(offset_s * SECOND, drift_ppm=50.0, since_ns=time.time_ns())
    given, path, status, report = record(tmp_path, clock, 6.0, enough=has_drift)
    assert report.complete
    found = np.array([frame.camera_time_ns for frame in frames(path)])
    assert np.abs(found - given).max() < 1_000_000
    told = info(path).metadata["accounting"]
    assert told["clock_source"] == "camera, mapped to this host's UTC"
    assert int(told["clock_offset_ns"]) == pytest.approx(-offset_s * SECOND, abs=2_000_000)
    # Six samples and more over 6 s, each to 0.2 ms on a busy host: a slope to 0.2 ms / 4 s.
    assert float(told["clock_drift_ppm"]) == pytest.approx(50.0, abs=50.0)
    assert status.clock["clock_source"] == told["clock_source"]


def test_camera_whose_clock_keeps_utc_keeps_its_times_to_the_nanosecond(tmp_path):
    given, path, _, _ = record(tmp_path, DeviceClock(), 1.0)
    assert [frame.camera_time_ns for frame in frames(path)] == given


def test_camera_without_ticks_is_noticed_and_said(tmp_path):
    _, path, status, report = record(tmp_path, DeviceClock(ticks=False), 0.5)
    assert status.clock["clock_source"] == "host"
    assert EventKind.CLOCK_MISSING in {event.kind for event in report.events}
    for frame in frames(path):
        assert frame.camera_time_ns == frame.host_time_ns
