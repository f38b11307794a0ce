"""A receiver made of the real Aravis, as the station's driver uses it."""

import time
import warnings
from dataclasses import dataclass

import gi

gi.require_version("Aravis", "0.8")
with warnings.catch_warnings():
    # PyGObject 3.42's importer is of a kind that Python 3.11 warns of.
    warnings.simplefilter("ignore", ImportWarning)
    from gi.repository import Aravis


_TRIES = 200
_BLOCK_S = 0.02  # packets reach Aravis in blocks, after 5 ms at the latest
_RETENTION_S = 5.0
_LONGER_THAN_RETENTION_S = _RETENTION_S + 1.0
"""Frames come in order: one of which a packet is gone for good holds all others up, then comes as
it is.  Who waits for less long sees no frame at all, and not why."""


@dataclass(frozen=True)
class Received:
    frame_id: int
    timestamp_ns: int
    whole: bool
    data: bytes
    region: tuple[int, int, int, int]


class Receiver:
    """Opens a camera, and takes frames while used as a context manager."""

    def __init__(self, address, *, packet_bytes=9000, buffers=128):
        self.camera = Aravis.Camera.new(address)
        self.camera.gv_set_packet_size(packet_bytes)
        self._buffers = buffers
        self._stream = None

    @property
    def device(self):
        return self.camera.get_device()

    def __enter__(self):
        self._stream = self._open_stream()
        self._stream.set_property("frame-retention", round(_RETENTION_S * 1e6))
        # A receiver that was not given the processor for a while misses most of a frame.
        self._stream.set_property("packet-request-ratio", 1.0)
        for _ in range(self._buffers):
            self._stream.push_buffer(Aravis.Buffer.new_allocate(self.camera.get_payload()))
        self.camera.start_acquisition()
        return self

    def __exit__(self, *_):
        self.camera.stop_acquisition()
        self._stream = None

    def close(self):
        """Give the camera back: Aravis does when nobody refers to it any more."""
        self._stream = None
        self.camera = None

    def _open_stream(self):
        """Return a stream that has seen no packets of other cameras.

        Aravis 0.8.26 opens its packet socket for everything on every interface, and tells it
        what to let through some milliseconds later. What other cameras send in between is
        taken for packets of this one: its first frames then seem late and are ignored, or get
        the pixels of another camera under the same number.
        """
        for _ in range(_TRIES):
            stream = self.camera.create_stream(None, None)
            time.sleep(_BLOCK_S)
            if stream.get_info_uint64_by_name("n_received_packets") == 0:
                return stream
            del stream
        raise TimeoutError("other cameras send so much that no stream can be opened cleanly")

    def next(self, timeout_s=_LONGER_THAN_RETENTION_S):
        """Return the next frame, or None where none comes in time."""
        buffer = self._stream.timeout_pop_buffer(round(timeout_s * 1e6))
        if buffer is None:
            return None
        whole = buffer.get_status() == Aravis.BufferStatus.SUCCESS
        region = tuple(buffer.get_image_region()) if whole else (0, 0, 0, 0)
        received = Received(
            buffer.get_frame_id(), buffer.get_timestamp(), whole, buffer.get_data(), region
        )
        self._stream.push_buffer(buffer)
        return received

    def take(self, count, timeout_s=_LONGER_THAN_RETENTION_S):
        """Return `count` frames, fewer where they stop coming."""
        frames = []
        while len(frames) < count:
            frame = self.next(timeout_s)
            if frame is None:
                break
            frames.append(frame)
        return frames


def wait_until(condition, timeout_s=30.0):
    """Return whether `condition` becomes true in time."""
    until_s = time.monotonic() + timeout_s
    while time.monotonic() < until_s:
        if condition():
            return True
        time.sleep(0.005)
    return False
