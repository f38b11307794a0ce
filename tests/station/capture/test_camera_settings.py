"""Settings reach the camera, are read back, stand in the recording; others are refused plainly."""

import re

import pytest
from capture_rig import capture_of, is_idle, plan_for, sensor_at, small_camera, wait_for
from pydantic import ValidationError

from station.capture.camera import Camera
from station.capture.features import Wanted
from station.errors import CameraRefused
from station.recording import frames, info
from station.settings import SensorSettings

ADDRESS = "127.20.2.1"

EVERYTHING = {
    "exposure_us": 700.0,
    "gain_db": 6.0,
    "black_level": 12.0,
    "region": {"offset_x_px": 32, "offset_y_px": 16, "width_px": 200, "height_px": 100},
    "trigger_activation": "FallingEdge",
    "trigger_delay_us": 40.0,
    "trigger_debounce_us": 25.0,
    "packet_delay_ns": 2000,
    "laser_output": "UserOutput0",
    "features": {"DeviceUserID": "left rail", "AcquisitionFrameCount": 7},
}


@pytest.fixture(scope="module", autouse=True)
def served():
    with small_camera(ADDRESS) as camera:
        yield camera


def opened(**settings):
    return Camera(sensor_at(ADDRESS, **settings))


def refusal(**settings):
    with pytest.raises(CameraRefused) as caught:
        opened(**settings)
    message = str(caught.value)
    assert "\n" not in message
    assert ADDRESS in message
    return message


def test_every_setting_is_in_the_camera_and_in_the_recording(tmp_path, served):
    path = tmp_path / "a.mcap"
    with capture_of(sensor_at(ADDRESS, **EVERYTHING), tmp_path) as (client, _):
        wait_for(client, is_idle)
        client.arm(plan_for(path))
        assert served.trigger_line1()
        assert client.finish(1).complete
    told = info(path).metadata["camera"]
    expected = {
        "exposure_us": "700.0",
        "gain_db": "6.0",
        "width": "200",
        "height": "100",
        "packet_delay_ns": "2000",
        "feature.OffsetX": "32",
        "feature.OffsetY": "16",
        "feature.BlackLevel": "12.0",
        "feature.TriggerSource": "Line1",
        "feature.TriggerActivation": "FallingEdge",
        "feature.TriggerDelay": "40.0",
        "feature.LineDebouncerTime": "25.0",
        "feature.DeviceUserID": "left rail",
        "feature.AcquisitionFrameCount": "7",
        "setting.laser_output": "True",
    }
    assert expected.items() <= told.items()
    (frame,) = frames(path)
    assert frame.picture.shape == (100, 200)
    assert frame.picture.min() >= 12  # the black level


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"exposure_us": 2.0}, "exposure 2 us is asked .* it takes 10 to 1e\\+06 us"),
        ({"gain_db": 90.0}, "gain 90 dB is asked .* it takes 0 to 24 dB"),
        ({"frame_rate_hz": 9000.0}, "frame rate 9000 Hz is asked .* it takes 0.1 to 2000 Hz"),
        ({"black_level": 65.0}, "black_level = 65 .* it takes 0 to 64"),
        ({"region": {"width_px": 321}}, "region.width_px = 321 .* it takes 16 to 320"),
        ({"region": {"offset_y_px": 230}}, "region.height_px = 16|region.offset_y_px = 230"),
        ({"region": {"binning_x": 2}}, "region.binning_x = 2 .* no feature BinningHorizontal"),
        ({"trigger_activation": "AnyEdge"}, "AnyEdge .* one of RisingEdge, FallingEdge"),
        ({"trigger_delay_us": 2e6}, r"trigger_delay_us = 2e\+06 .* it takes 0 to 1e\+06"),
        ({"trigger_debounce_us": 2e5}, "trigger_debounce_us = 200000 .* it takes 0 to 100000"),
        ({"outputs": {"UserOutput7": True}}, "outputs.UserOutput7 .* one of UserOutput0"),
        ({"features": {"Gamma": 1.0}}, "features.Gamma = 1 .* no feature Gamma"),
        ({"features": {"PixelFormat": "Mono12"}}, "Mono12 .* it takes one of Mono8"),
        ({"features": {"WidthMax": 9}}, "features.WidthMax = 9 .* can only be read and is 320"),
        ({"features": {"UserOutputValue": 3}}, "UserOutputValue .* it takes true or false"),
        ({"features": {"ExposureTime": "long"}}, "long .* it takes 10 to 1e\\+06"),
        ({"features": {"DeviceUserID": 5}}, "DeviceUserID .* it takes a text"),
        ({"features": {"AcquisitionStop": 1}}, "is a command and takes true"),
    ],
)
def test_setting_the_camera_does_not_take_is_refused_with_what_it_takes(settings, said):
    message = refusal(**settings)
    assert re.search(said, message), message


def test_setting_undone_by_another_one_is_refused():
    message = refusal(features={"Width": 100}, region={"width_px": 200})
    assert "features.Width = 100" in message
    assert "it holds 200 after it was set" in message


def test_region_left_small_by_another_program_is_whole_again():
    small = opened(region={"width_px": 64, "height_px": 64, "offset_x_px": 100})
    small.close(lost=False)
    del small
    whole = opened()
    assert (whole.width, whole.height) == (320, 240)
    whole.close(lost=False)


def test_region_without_a_size_reaches_to_the_edge():
    camera = opened(region={"offset_x_px": 20, "offset_y_px": 40})
    assert (camera.width, camera.height) == (300, 200)
    camera.close(lost=False)


def test_camera_that_ignores_a_value_is_found_out(monkeypatch):
    camera = opened()
    monkeypatch.setattr(camera._features, "_write", lambda name, value: None)
    with pytest.raises(CameraRefused, match="it holds .* after it was set"):
        camera._features.set(Wanted("black_level", ("BlackLevel",), 55.0))
    camera.close(lost=False)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"calibration_exposures": [{"exposure_us": 5, "laser": False}]}, "give laser_output"),
        ({"laser_output": "A", "outputs": {"A": True}}, "take it out of outputs"),
        ({"region": {"width": 5}}, "Extra inputs"),
        ({"packet_delay_ns": -1}, "greater than or equal to 0"),
    ],
)
def test_settings_that_contradict_themselves_are_refused_before_any_camera(settings, said):
    with pytest.raises(ValidationError, match=said):
        SensorSettings(id="left", address=ADDRESS, **settings)
