"""Small recordings with known content."""

import resource
import signal
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from station.recording import Event, EventKind, RecordingWriter

START_NS = 1_760_000_000_000_000_000
PERIOD_NS = 18_867_924  # 53 Hz
WIDTH, HEIGHT = 64, 48
CALIBRATION = b'{"format": "treadline-calibration"}'


def picture(rng, height=HEIGHT, width=WIDTH):
    return rng.integers(0, 256, (height, width), dtype=np.uint8)


def write_picture(writer, frame_id, pixels, *, sensor="left", delay_ns=5_000_000):
    height, width = pixels.shape
    time_ns = START_NS + frame_id * PERIOD_NS
    view = pixels.data.cast("B")
    writer.write_frame(sensor, frame_id, time_ns, time_ns + delay_ns, view, width, height)


def started(time_ns=START_NS):
    return Event(EventKind.STARTED, time_ns, "a pass")


def make_recording(path: Path, rng, count=5):
    """Write a recording of `count` frames; return its pictures."""
    pictures = [picture(rng) for _ in range(count)]
    metadata = {"camera": {"sensor": "left", "exposure_us": "250.0"}}
    attachments = {"calibration.json": CALIBRATION}
    with RecordingWriter(path, metadata=metadata, attachments=attachments) as writer:
        writer.write_event("left", started())
        for number, pixels in enumerate(pictures, 1):
            write_picture(writer, number, pixels)
    return pictures


@contextmanager
def no_file_beyond(size):
    """Let the system refuse to let any file grow beyond a size, as a full disk does.

    Within the test alone: the file that the test runner reports to may be larger already.
    """
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
