"""A camera in its own process at full size and speed, commanded over a pipe, killed and gone."""

from functools import partial

import numpy as np
import pytest
from aravis_receiver import Receiver
from simulated_pictures import numbered_pictures, numbered_source

from station.errors import CameraError, CameraLost, InputUnusable
from station.simulated import Faults, SimulatedCameraProcess, probe_camera

WIDTH, HEIGHT = 2048, 1088
FULL_SIZE = partial(numbered_source, 8, WIDTH, HEIGHT)
SMALL = partial(numbered_source, 2, 64, 48)


def broken_source():
    raise InputUnusable("nothing to look at")


@pytest.mark.parametrize("packet_loss", [0.0, 0.01])
def test_full_size_at_53_pictures_a_second_arrives_byte_for_byte(packet_loss):
    pictures = [picture.tobytes() for picture in numbered_pictures(8, WIDTH, HEIGHT)]
    faults = Faults(packet_loss=packet_loss, seed=1)
    with SimulatedCameraProcess("127.10.5.1", FULL_SIZE, faults=faults) as camera:
        receiver = Receiver(camera.address, buffers=64)
        receiver.camera.set_frame_rate(53.0)
        with receiver:
            frames = []
            for _ in range(160):
                frame = receiver.next()
                # Compared here: keeping three seconds of pictures would take 350 MB.
                assert frame.data == pictures[(frame.frame_id - 1) % 8]
                frames.append((frame.frame_id, frame.timestamp_ns))
        receiver.close()
        statistics = camera.statistics()
    ids, times = np.array(frames).T
    np.testing.assert_array_equal(ids, np.arange(1, 161))
    # The camera's own schedule, so that only rounding to whole ns and the slewing of the host's
    # clock (500 ppm at most, 0.01 ms in a period) are left; a late sensor thread adds nothing.
    assert np.median(np.diff(times)) * 1e-9 == pytest.approx(1 / 53.0, abs=1e-4)
    # 160 frames of 249 packets at 1 %: 398 expected, sigma 20.
    assert 300 * bool(packet_loss) <= statistics.dropped_packets <= 500 * bool(packet_loss)


def test_triggers_reach_the_camera_with_their_times():
    with SimulatedCameraProcess("127.10.5.4", SMALL) as camera:
        assert not camera.trigger_line1(5)
        receiver = Receiver(camera.address)
        receiver.camera.set_trigger("Line1")
        with receiver:
            assert camera.trigger_line1(1_750_000_000_000_000_007)
            assert receiver.next().timestamp_ns == 1_750_000_000_000_000_007
        receiver.close()


def test_a_killed_camera_is_gone_and_its_address_is_free():
    camera = SimulatedCameraProcess("127.10.5.5", SMALL)
    camera.start()
    camera.kill()
    camera.kill()
    assert probe_camera(camera._address, timeout_s=0.2) is None
    with pytest.raises(CameraError, match="does not run"):
        camera.trigger_line1()
    with camera:
        assert probe_camera(camera._address) is not None
    camera.stop()


def test_a_process_that_died_by_itself_is_said_to_be_lost():
    with SimulatedCameraProcess("127.10.5.6", SMALL) as camera:
        camera._process.kill()
        camera._process.join()
        with pytest.raises(CameraLost, match="has ended"):
            camera.trigger_line1()


def test_a_frozen_process_is_not_found_and_a_thawed_one_is():
    with SimulatedCameraProcess("127.10.5.7", SMALL) as camera:
        camera.freeze()
        assert probe_camera(camera._address, timeout_s=0.2) is None
        camera.thaw()
        assert probe_camera(camera._address) is not None


def test_what_the_start_refuses_is_refused_here():
    with pytest.raises(InputUnusable, match="nothing to look at"):
        SimulatedCameraProcess("127.10.5.8", broken_source).start()
    with SimulatedCameraProcess("127.10.5.9", SMALL):
        second = SimulatedCameraProcess("127.10.5.9", SMALL)
        with pytest.raises(InputUnusable, match="in use"):
            second.start()
        assert second.pid is None
