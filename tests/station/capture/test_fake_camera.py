"""Aravis' own camera goes the whole way too; it has no network, no clock and no resends."""

import pytest
from capture_rig import capture_of, is_idle, plan_for, wait_for

from station.capture.camera import FAKE, Camera
from station.capture.stream import _FakeIds
from station.errors import CameraRefused
from station.recording import EventKind, frames, info, verify
from station.settings import SensorSettings


def fake(**settings):
    known = {"trigger": "free", "ring_slots": 16, "frame_rate_hz": 25.0, **settings}
    return SensorSettings(id="left", address=FAKE, **known)


def test_fake_camera_is_recorded_end_to_end(tmp_path):
    path = tmp_path / "a.mcap"
    with capture_of(fake(exposure_us=5000.0), tmp_path) as (client, _):
        wait_for(client, is_idle)
        client.arm(plan_for(path, "free", frames=10))
        wait_for(client, lambda status: status.recorded == 10)
        report = client.finish()
    assert (report.recorded, report.lost, report.complete) == (10, 0, True)
    assert verify(path).ok
    seen = list(frames(path))
    assert [frame.frame_id for frame in seen] == list(range(1, 11))
    assert seen[0].picture.shape == (2048, 2048)
    assert seen[0].exposure_us == pytest.approx(5000.0)
    told = info(path).metadata
    assert told["camera"]["model"] == "Fake"
    # It has no clock: its frames bear the time of reception, and the recording says so.
    assert told["accounting"]["clock_source"] == "host"
    assert EventKind.CLOCK_MISSING in {event.kind for event in report.events}


def test_binning_and_region_are_set_where_the_camera_has_them():
    camera = Camera(fake(region={"width_px": 128, "height_px": 96, "offset_x_px": 8}))
    assert (camera.width, camera.height) == (128, 96)
    assert camera.description()["feature.OffsetX"] == "8"
    camera.close(lost=False)


def test_fake_camera_refuses_what_it_does_not_take():
    with pytest.raises(CameraRefused, match="region.binning_x = 64 is asked of BinningHorizontal"):
        Camera(fake(region={"binning_x": 64}))


def test_trigger_the_camera_has_not_is_refused_with_those_it_has():
    with pytest.raises(CameraRefused, match="trigger = Line1 is asked of .* it takes .*Software"):
        Camera(fake(trigger="Line1"))


def test_its_numbers_go_on_where_its_counter_turns_over():
    ids = _FakeIds()
    given = [65534, 65535, 0, 1, 3]
    assert [ids.of(one) for one in given] == [1, 2, 3, 4, 6]
