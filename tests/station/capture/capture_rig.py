"""A simulated camera, a capture process that records it, and what was served."""

import time
from contextlib import contextmanager

import numpy as np

from station.capture import CaptureClient, CaptureState, RecordingPlan, start_capture
from station.recording import frames
from station.settings import SensorSettings
from station.simulated import ArraySource, SimulatedCamera

WIDTH, HEIGHT, PICTURES = 320, 240, 16
PACKET_SIZE = 1500


def served_pictures(width=WIDTH, height=HEIGHT, count=PICTURES):
    rng = np.random.default_rng(11)
    return [rng.integers(0, 256, (height, width), dtype=np.uint8) for _ in range(count)]


def full_size_source():
    return ArraySource(served_pictures(2048, 1088))


def small_camera(address, **arguments):
    return SimulatedCamera(address, ArraySource(served_pictures()), **arguments)


def sensor_at(address, **settings):
    settings = {"packet_size": PACKET_SIZE, "ring_slots": 16, **settings}
    return SensorSettings(id="left", address=address, **settings)


@contextmanager
def capture_of(settings, folder):
    """Run a capture process; yield its client and its handle."""
    path = folder / "s.sock"
    process = start_capture(settings, path)
    try:
        yield CaptureClient(path), process
    finally:
        process.terminate()
        process.join(20)
        process.kill()
        process.join()


def plan_for(path, trigger="Line1", **arguments):
    return RecordingPlan("pass-7", path, "left", trigger, **arguments)


def wait_for(client, wanted, timeout_s=20.0):
    """Wait until the status satisfies a predicate; return it."""
    deadline = time.monotonic() + timeout_s
    while not wanted(status := client.status()):
        assert time.monotonic() < deadline, status
        time.sleep(0.02)
    return status


def is_idle(status):
    return status.state is CaptureState.IDLE


def assert_served(path, first_exposure, ids, width=WIDTH, height=HEIGHT):
    """Check frame by frame that a recording holds what the camera served, byte for byte."""
    pictures = served_pictures(width, height)
    found = []
    for frame in frames(path):
        exposure = first_exposure + frame.frame_id - 1
        np.testing.assert_array_equal(frame.picture, pictures[exposure % PICTURES])
        found.append(frame.frame_id)
    assert found == list(ids)
