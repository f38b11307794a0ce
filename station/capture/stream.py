"""Frames as they come from the camera, each received straight into a slot of the ring."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from station.capture.aravis import Aravis
from station.capture.ring import Ring

# Aravis 0.8.26 measures a frame's age from its first packet's slot in the queue: with its default
# of 0.1 s the first frame after a pause is given up before it is complete.
_FRAME_RETENTION_US = 5_000_000


@dataclass(frozen=True, slots=True)
class ReceivedFrame:
    """A frame in its slot, whole or not."""

    slot: int
    frame_id: int
    camera_ns: int
    """The camera's timestamp, ns."""
    received_ns: int
    """When its first packet came, this host's clock, UTC."""
    width: int
    height: int
    flaw: str | None
    """Why it is incomplete; None where it is whole."""


@dataclass(frozen=True, slots=True)
class StreamCounters:
    """What the driver counts."""

    resent_packets: int = 0
    underruns: int = 0
    """Frames that met no free slot."""


class FrameStream:
    """The open stream of an acquiring camera.

    It is asked for frames, never called back: a callback waits for the interpreter's lock in the
    thread that must empty the socket.
    """

    def __init__(self, stream: Any, ring: Ring, payload_bytes: int, free_slots: set[int]) -> None:
        stream.set_property("socket-buffer", Aravis.GvStreamSocketBuffer.AUTO)
        stream.set_property("frame-retention", _FRAME_RETENTION_US)
        self._stream = stream
        self._ring = ring
        self._payload_bytes = payload_bytes
        self._slot_of: dict[Any, int] = {}
        self._buffers: dict[int, Any] = {}
        for slot in sorted(free_slots):
            self.give_back(slot)

    @property
    def in_flight(self) -> bool:
        """Whether a frame is being received or waits to be taken."""
        free, received = self._stream.get_n_buffers()
        return bool(received or free < len(self._given))

    def give_back(self, slot: int) -> None:
        """Let a slot be filled."""
        if slot not in self._buffers:
            address = self._ring.address(slot)
            buffer = Aravis.Buffer.new(self._payload_bytes, address)
            self._buffers[slot] = buffer
            self._slot_of[buffer] = slot
        self._stream.push_buffer(self._buffers[slot])
