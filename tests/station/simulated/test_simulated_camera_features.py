"""The real Aravis finds the camera, reads it, sets it, and is refused what is wrong."""

import time

import pytest
from aravis_receiver import Aravis, Receiver, wait_until
from gi.repository import GLib
from simulated_pictures import numbered_source

from station.errors import CameraError, InputUnusable
from station.simulated import SimulatedCamera, probe_camera
from station.simulated.gvsp import MONO8

WIDTH, HEIGHT = 320, 240


@pytest.fixture
def camera():
    with SimulatedCamera("127.10.2.1", numbered_source(4, WIDTH, HEIGHT), serial="TL-1") as camera:
        yield camera


@pytest.fixture
def receiver(camera):
    receiver = Receiver(camera.address)
    yield receiver
    receiver.close()


def test_a_search_of_the_network_finds_every_camera():
    addresses = {"127.10.2.3", "127.10.2.4", "127.77.0.9"}
    cameras = [SimulatedCamera(a, numbered_source(1, 64, 48)) for a in sorted(addresses)]
    for camera in cameras:
        camera.start()
    try:
        Aravis.update_device_list()
        count = Aravis.get_n_devices()
        found = {
            Aravis.get_device_address(i): Aravis.get_device_serial_nbr(i) for i in range(count)
        }
    finally:
        for camera in cameras:
            camera.stop()
    # There may be others: tests run beside these that have cameras of their own.
    assert found.keys() >= addresses
    assert {found[camera.address] for camera in cameras} == {c.serial for c in cameras}


def test_asking_an_address_tells_who_is_there(camera):
    identity = probe_camera(camera._identity.address)
    assert identity == camera._identity


def test_every_feature_of_the_description_is_read(receiver):
    genicam = receiver.device.get_genicam()
    device = receiver.device
    read = {}
    todo = ["Root"]
    while todo:
        node = genicam.get_node(todo.pop())
        if isinstance(node, Aravis.GcCategory):
            todo += node.get_features()
        elif not isinstance(node, Aravis.GcCommand):
            read[node.get_name()] = node.get_value_as_string()
    assert read["DeviceSerialNumber"] == "TL-1"
    assert read["SensorWidth"] == str(WIDTH)
    assert read["PixelFormat"] == "Mono8"
    assert read["PayloadSize"] == str(WIDTH * HEIGHT)
    assert read["TLParamsLocked"] == "0"
    assert read["GevTimestampTickFrequency"] == "1000000000"
    assert device.get_integer_feature_value("GevCurrentIPAddress") == 0x7F0A0201
    assert read["DeviceTemperature"] == "42.5"
    assert len(read) == 47


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ExposureTime", 1234.5),
        ("Gain", 6.25),
        ("AcquisitionFrameRate", 53.7),
        ("AcquisitionFrameCount", 17),
        ("AcquisitionMode", "MultiFrame"),
        ("AcquisitionFrameRateEnable", False),
        ("TriggerMode", "On"),
        ("TriggerSource", "Line1"),
        ("TriggerSelector", "FrameStart"),
        ("DeviceUserID", "left 1"),
        ("GevSCPSPacketSize", 8000),
        ("GevSCPD", 1000),
        ("GevHeartbeatTimeout", 5000),
        ("Width", 160),
        ("Height", 100),
    ],
)
def test_a_feature_reads_back_what_was_set(receiver, name, value):
    device = receiver.device
    kind = {float: "float", int: "integer", str: "string", bool: "boolean"}[type(value)]
    getattr(device, f"set_{kind}_feature_value")(name, value)
    assert getattr(device, f"get_{kind}_feature_value")(name) == value


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("ExposureTime", 1.0),
        ("ExposureTime", 2e6),
        ("Gain", 48.0),
        ("AcquisitionFrameRate", 1e6),
        ("Width", WIDTH + 1),
        ("Height", 0),
        ("OffsetX", 1),
        ("GevSCPSPacketSize", 9001),
        ("SensorWidth", 1),
    ],
)
def test_a_value_out_of_range_is_refused_by_the_camera_itself(receiver, name, value):
    device = receiver.device
    kind = "float" if isinstance(value, float) else "integer"
    before = getattr(device, f"get_{kind}_feature_value")(name)
    with pytest.raises(GLib.Error):
        getattr(device, f"set_{kind}_feature_value")(name, value)
    assert getattr(device, f"get_{kind}_feature_value")(name) == before


def test_bounds_follow_the_other_settings(receiver):
    device = receiver.device
    device.set_integer_feature_value("Width", 200)
    assert device.get_integer_feature_bounds("OffsetX")[:2] == (0, WIDTH - 200)
    device.set_integer_feature_value("OffsetX", 50)
    assert device.get_integer_feature_bounds("Width")[:2] == (16, WIDTH - 50)
    assert device.get_integer_feature_value("PayloadSize") == 200 * HEIGHT


def test_the_pixel_format_is_mono8_and_no_other(receiver):
    assert list(receiver.camera.dup_available_pixel_formats()) == [MONO8]
    with pytest.raises(GLib.Error):
        receiver.device.set_string_feature_value("PixelFormat", "Mono12")


def test_the_latched_time_is_the_time_of_the_pictures(receiver):
    before_ns = time.time_ns()
    receiver.device.execute_command("GevTimestampControlLatch")
    latched_ns = receiver.device.get_integer_feature_value("GevTimestampValue")
    assert before_ns <= latched_ns <= time.time_ns()


def test_the_camera_finds_the_largest_packet_that_gets_through(receiver):
    receiver.camera.gv_set_packet_size_adjustment(Aravis.GvPacketSizeAdjustment.ALWAYS)
    stream = receiver.camera.create_stream(None, None)
    # Loopback carries 64 KiB: the camera's own limit is what is found, to a step of 4 bytes.
    assert receiver.camera.gv_get_packet_size() > 16_000
    del stream


def test_a_second_client_is_denied_control(camera, receiver):
    second = Aravis.Camera.new(camera.address)
    assert not second.get_device().is_controller()
    with pytest.raises(GLib.Error, match="denied|ACCESS"):
        second.set_exposure_time(500.0)
    assert receiver.device.is_controller()


def test_control_is_free_again_once_its_client_is_silent(camera):
    first = Receiver(camera.address)
    first.device.set_integer_feature_value("GevHeartbeatTimeout", 500)
    first.__enter__()
    assert first.next() is not None
    camera.freeze()  # to the camera, its client falls silent
    assert wait_until(lambda: not camera._device.acquisition.running)
    camera.thaw()
    with pytest.raises(GLib.Error, match="denied"):
        first.camera.stop_acquisition()
    second = Receiver(camera.address)
    assert second.device.is_controller()
    first.close()
    second.close()


def test_a_frozen_camera_is_not_found_and_a_thawed_one_is(camera):
    camera.freeze()
    assert probe_camera(camera._identity.address, timeout_s=0.3) is None
    camera.thaw()
    assert probe_camera(camera._identity.address, timeout_s=0.3) is not None


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("127.10.2.1", "in use"),
        ("10.255.255.254", "no address of this host"),
        ("camera one", "no IPv4 address"),
    ],
)
def test_an_address_that_cannot_be_had_is_refused_in_one_line(camera, address, message):
    with pytest.raises(InputUnusable, match=message) as refusal:
        SimulatedCamera(address, numbered_source(1, 64, 48)).start()
    assert "\n" not in str(refusal.value)


def test_pictures_too_small_to_be_sent_are_refused():
    with pytest.raises(InputUnusable, match="8 × 8 px"):
        SimulatedCamera("127.10.2.9", numbered_source(1, 8, 8))


def test_a_stopped_camera_gives_its_address_back():
    for _ in range(3):
        with SimulatedCamera("127.10.2.8", numbered_source(1, 64, 48)) as camera:
            camera.stop()
            camera.stop()
    with pytest.raises(CameraError, match="does not run"):
        camera.trigger_line1()
