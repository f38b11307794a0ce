"""A simulated camera, a capture process that records it, and what was served."""

import os
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from station.capture import CaptureClient, CaptureState, RecordingPlan, start_capture
from station.recording import frames
from station.settings import SensorSettings
from station.simulated import ArraySource, SimulatedCamera

WIDTH, HEIGHT, PICTURES = 320, 240, 16
PACKET_SIZE = 1500
PATIENCE_S = 60.0
RING_SLOTS = 128
"""For a busy host, where the recorder may not be given the processor for a second."""


def served_pictures(width=WIDTH, height=HEIGHT, count=PICTURES):
    rng = np.random.default_rng(11)
    return [rng.integers(0, 256, (height, width), dtype=np.uint8) for _ in range(count)]


def full_size_source():
    return ArraySource(served_pictures(2048, 1088))


def small_camera(address, **arguments):
    return SimulatedCamera(address, ArraySource(served_pictures()), **arguments)


def sensor_at(address, **settings):
    settings = {"packet_size": PACKET_SIZE, "ring_slots": RING_SLOTS, **settings}
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
        process.join(PATIENCE_S)
        process.kill()
        process.join()


def plan_for(path, trigger="Line1", **arguments):
    return RecordingPlan("pass-7", path, "left", trigger, **arguments)


def wait_until(happened, timeout_s=PATIENCE_S):
    """Wait until something has happened; return what tells of it."""
    deadline = time.monotonic() + timeout_s
    while not (found := happened()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return found


def recorder_of(process):
    """Return the process id of the recorder, the capture process's only child.

    There is none for a moment while one that died is followed by another.
    """
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    (child,) = wait_until(lambda: children.read_text().split())
    return int(child)


def is_running(pid):
    """Whether a process still has its files open; one that waits to be reaped has not.

    Its first thread may wait while others are still on their way out, the files open.
    """
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        return state != "Z" or len(os.listdir(f"/proc/{pid}/task")) > 1
    except (FileNotFoundError, ProcessLookupError):
        return False


def wait_for(client, wanted, timeout_s=PATIENCE_S):
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
