"""Pictures arrive at the real Aravis as the source gave them, whatever the link does to them."""

import numpy as np
import pytest
from aravis_receiver import Receiver, wait_until
from simulated_pictures import numbered_pictures

from station.errors import CameraError
from station.simulated import ArraySource, DeviceOptions, Faults, SceneSource, SimulatedCamera

WIDTH, HEIGHT, COUNT = 640, 400, 5
PICTURES = numbered_pictures(COUNT, WIDTH, HEIGHT)
# What Aravis misses while a busy host lets it wait can still be asked for.
FAST = DeviceOptions(frame_rate_hz=150.0, resend_frames=128)
PATIENT = DeviceOptions(frame_rate_hz=30.0, resend_frames=64)


def stream(count, *, address="127.10.3.1", faults=None, options=FAST, **settings):
    """Return what Aravis received of `count` frames in free run, and the camera's statistics."""
    source = ArraySource(PICTURES)
    with SimulatedCamera(address, source, faults=faults, options=options) as camera:
        receiver = Receiver(address, **settings)
        receiver.camera.set_exposure_time(1000.0)
        with receiver:
            frames = receiver.take(count)
        receiver.close()
        return frames, camera.statistics()


def assert_identical(frames):
    for frame in frames:
        assert frame.whole
        assert frame.data == PICTURES[(frame.frame_id - 1) % COUNT].tobytes()


def test_pictures_arrive_byte_for_byte_and_numbered():
    frames, statistics = stream(50)
    assert [frame.frame_id for frame in frames] == list(range(1, 51))
    assert_identical(frames)
    assert statistics.dropped_packets == statistics.lost_frames == 0


@pytest.mark.parametrize("packet_bytes", [576, 1500, 9000, 16384])
def test_every_packet_size_carries_the_same_picture(packet_bytes):
    frames, _ = stream(5, packet_bytes=packet_bytes, options=PATIENT)
    assert len(frames) == 5
    assert_identical(frames)


def test_dropped_packets_are_sent_again():
    frames, statistics = stream(100, faults=Faults(packet_loss=0.03, seed=3))
    assert [frame.frame_id for frame in frames] == list(range(1, 101))
    assert_identical(frames)
    # 100 frames of 31 packets at 3 %: 93 expected, sigma 9.5.
    assert statistics.dropped_packets > 45
    assert statistics.resent_packets > 45


def test_doubled_packets_change_nothing():
    frames, statistics = stream(50, faults=Faults(packet_duplication=0.1))
    assert len(frames) == 50
    assert_identical(frames)
    assert statistics.duplicated_packets > 50


def test_packets_out_of_order_change_nothing():
    frames, _ = stream(50, faults=Faults(packet_reorder=0.1))
    assert len(frames) == 50
    assert_identical(frames)


def test_all_packet_faults_together_change_nothing():
    faults = Faults(packet_loss=0.02, packet_duplication=0.02, packet_reorder=0.05, seed=11)
    frames, _ = stream(50, faults=faults)
    assert [frame.frame_id for frame in frames] == list(range(1, 51))
    assert_identical(frames)


def test_lost_frames_show_as_gaps_in_the_ids():
    faults = Faults(lost_frames=frozenset({0, 3, 4, 9}))
    frames, statistics = stream(16, faults=faults)
    assert [frame.frame_id for frame in frames] == [
        number for number in range(1, 21) if number - 1 not in faults.lost_frames
    ]
    assert_identical(frames)
    assert statistics.lost_frames == 4


def test_late_packets_arrive_all_the_same():
    frames, _ = stream(20, faults=Faults(delay_s=0.1))
    assert [frame.frame_id for frame in frames] == list(range(1, 21))
    assert_identical(frames)


def test_ids_wrap_from_65535_to_1():
    options = DeviceOptions(frame_rate_hz=100.0, first_block_id=65533)
    frames, _ = stream(6, options=options)
    assert [frame.frame_id for frame in frames] == [65533, 65534, 65535, 1, 2, 3]
    served = [PICTURES[i % COUNT].tobytes() for i in range(6)]
    assert [frame.data for frame in frames] == served


def test_packets_of_an_earlier_acquisition_are_not_sent_again():
    faults = Faults(packet_loss=0.2, seed=8)
    options = DeviceOptions(frame_rate_hz=100.0, resend_frames=64)
    with SimulatedCamera("127.10.3.14", ArraySource(PICTURES), faults=faults, options=options) as (
        camera
    ):
        receiver = Receiver(camera.address)
        receiver.device.set_string_feature_value("AcquisitionMode", "MultiFrame")
        receiver.device.set_integer_feature_value("AcquisitionFrameCount", 7)
        for acquisition in range(2):
            with receiver:
                frames = receiver.take(7)
            for frame in frames:  # the same ids again, but seven pictures on
                served = PICTURES[(7 * acquisition + frame.frame_id - 1) % COUNT]
                assert frame.whole
                assert frame.data == served.tobytes()
        receiver.close()


def test_packets_long_gone_are_said_to_be_unavailable():
    # Half of the packets are lost, half of those sent again too, and one picture is kept: many
    # requests come when their picture has gone.
    options = DeviceOptions(frame_rate_hz=100.0, resend_frames=1)
    _, statistics = stream(8, faults=Faults(packet_loss=0.5, seed=2), options=options)
    assert statistics.unavailable_packets > 0


def test_a_region_is_cut_from_the_picture_and_told_in_the_leader():
    with SimulatedCamera("127.10.3.2", ArraySource(PICTURES)) as camera:
        receiver = Receiver(camera.address)
        receiver.camera.set_region(100, 60, 200, 120)
        assert receiver.camera.get_payload() == 200 * 120
        with receiver:
            frame = receiver.next()
        receiver.close()
    assert frame.region == (100, 60, 200, 120)
    assert frame.data == PICTURES[0][60:180, 100:300].tobytes()


def test_two_cameras_stream_at_once():
    other_pictures = numbered_pictures(3, WIDTH, HEIGHT, seed=99)
    with (
        SimulatedCamera("127.10.3.3", ArraySource(PICTURES), options=FAST) as one,
        SimulatedCamera("127.10.3.4", ArraySource(other_pictures), options=FAST) as other,
    ):
        first, second = Receiver(one.address), Receiver(other.address)
        with first, second:
            pairs = [(first.next(), second.next()) for _ in range(20)]
        first.close()
        second.close()
    assert_identical([frame for frame, _ in pairs])
    for _, frame in pairs:
        assert frame.whole
        assert frame.data == other_pictures[(frame.frame_id - 1) % 3].tobytes()


def test_two_cameras_with_the_same_seed_drop_the_same_packets():
    counts = []
    for address in ("127.10.3.12", "127.10.3.13"):
        with SimulatedCamera(
            address, ArraySource(PICTURES), faults=Faults(packet_loss=0.2, seed=4), options=FAST
        ) as camera:
            receiver = Receiver(address)
            receiver.device.set_string_feature_value("AcquisitionMode", "MultiFrame")
            receiver.device.set_integer_feature_value("AcquisitionFrameCount", 20)
            with receiver:
                assert wait_until(lambda camera=camera: camera.statistics().sent == 20)
            receiver.close()
            counts.append(camera.statistics().dropped_packets)
    assert counts[0] == counts[1] > 0


@pytest.mark.parametrize(("mode", "count"), [("SingleFrame", 1), ("MultiFrame", 3)])
def test_an_acquisition_of_so_many_frames_gives_so_many(mode, count):
    with SimulatedCamera("127.10.3.5", ArraySource(PICTURES), options=PATIENT) as camera:
        receiver = Receiver(camera.address)
        receiver.device.set_string_feature_value("AcquisitionMode", mode)
        receiver.device.set_integer_feature_value("AcquisitionFrameCount", 3)
        with receiver:
            frames = receiver.take(count)
            assert receiver.next(timeout_s=0.3) is None  # 9 periods of the camera: nothing follows
        receiver.close()
        assert camera.statistics().sent == count
    assert [frame.frame_id for frame in frames] == list(range(1, count + 1))


def test_line1_triggers_carry_their_times_exactly():
    times = [1_700_000_000_123_456_789, 1_700_000_000_123_456_790, 1_800_000_000_000_000_001]
    with SimulatedCamera("127.10.3.6", ArraySource(PICTURES)) as camera:
        assert not camera.trigger_line1()  # nobody waits for it yet
        receiver = Receiver(camera.address)
        receiver.camera.set_frame_rate(53.0)
        receiver.camera.set_trigger("Line1")
        with receiver:
            assert all(camera.trigger_line1(at) for at in times)
            frames = receiver.take(len(times))
            assert receiver.next(timeout_s=0.2) is None  # and no picture without a trigger
        receiver.close()
        assert camera.statistics().missed_triggers == 1
    assert [frame.timestamp_ns for frame in frames] == times
    assert [frame.frame_id for frame in frames] == [1, 2, 3]


def test_a_software_trigger_takes_one_picture_each():
    with SimulatedCamera("127.10.3.7", ArraySource(PICTURES)) as camera:
        receiver = Receiver(camera.address)
        receiver.camera.set_frame_rate(53.0)
        receiver.camera.set_trigger("Software")
        with receiver:
            assert not camera.trigger_line1()
            for expected in (1, 2, 3):
                receiver.camera.software_trigger()
                assert receiver.next().frame_id == expected
            assert receiver.next(timeout_s=0.2) is None
        receiver.close()


def test_exposure_and_gain_reach_the_source():
    seen = []

    def render(_index, exposure_us):
        seen.append(exposure_us)
        return np.zeros((HEIGHT, WIDTH), np.uint8)

    source = SceneSource(render, width=WIDTH, height=HEIGHT)
    with SimulatedCamera("127.10.3.8", source) as camera:
        receiver = Receiver(camera.address)
        receiver.camera.set_exposure_time(2000.0)
        receiver.camera.set_gain(20.0)
        with receiver:
            receiver.next()
        receiver.close()
    assert seen[0] == pytest.approx(20_000.0)


def test_a_silent_camera_sends_nothing_and_its_exposures_count_as_lost():
    with SimulatedCamera("127.10.3.9", ArraySource(PICTURES), options=FAST) as camera:
        receiver = Receiver(camera.address)
        with receiver:
            receiver.take(3)
            camera.freeze()
            while receiver.next(timeout_s=0.1) is not None:
                pass
            assert wait_until(lambda: camera.statistics().lost_frames > 5)
            camera.thaw()
            frame = receiver.next()
            assert frame.frame_id > 8
            assert_identical([frame])
        receiver.close()


def test_a_source_that_fails_silences_the_camera_and_says_why():
    def render(_index, _exposure_us):
        raise ValueError("no more light")

    camera = SimulatedCamera("127.10.3.10", SceneSource(render, width=64, height=48))
    camera.start()
    receiver = Receiver(camera.address)
    with receiver:
        assert receiver.next(timeout_s=0.2) is None
        assert wait_until(lambda: camera.failure is not None)
        camera._device.frozen = False  # or Aravis would wait long for answers when it leaves
    receiver.close()
    with pytest.raises(CameraError, match="no more light"):
        camera.stop()


def test_a_picture_of_another_size_than_said_is_no_picture():
    source = SceneSource(lambda _i, _e: np.zeros((4, 4), np.uint8), width=64, height=48)
    camera = SimulatedCamera("127.10.3.11", source)
    camera.start()
    receiver = Receiver(camera.address)
    with receiver:
        assert wait_until(lambda: camera.failure is not None)
        camera._device.frozen = False
    receiver.close()
    with pytest.raises(CameraError, match="shape"):
        camera.stop()
