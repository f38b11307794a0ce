"""Frames as they come from the camera, each received straight into a slot of the ring."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from station.capture.aravis import Aravis
from station.capture.burial import bury
from station.capture.open_stream import OpenStream
from station.capture.ring import Ring

_MEMORY = "memory"
_NO_ID = 0
"""No frame has it.  A frame whose first packet is lost keeps the id its buffer had before."""


@dataclass(frozen=True, slots=True)
class ReceivedFrame:
    """A frame in its slot, whole or not."""

    slot: int
    frame_id: int | None
    """As the camera numbers them; None where the packet that says it is lost."""
    camera_ns: int
    """The camera's timestamp, ns."""
    received_ns: int
    """When its first packet came, this host's clock, UTC."""
    width: int
    height: int
    flaw: str | None
    """Why it is incomplete; None where it is whole."""


class FrameStream:
    """The open stream of an acquiring camera.

    It is asked for frames, never called back: a callback waits for the interpreter's lock in the
    very thread that must empty the socket.
    """

    def __init__(self, opened: OpenStream, ring: Ring, payload_bytes: int) -> None:
        self._stream = opened.stream
        self.method = opened.method
        """How packets are received."""
        self.buffer_bytes = opened.buffer_bytes
        """Room in the kernel for packets that wait."""
        self._counts = opened.method != _MEMORY
        self._ids = None if self._counts else _FakeIds()
        self._buffers = {
            slot: Aravis.Buffer.new(payload_bytes, ring.address(slot)) for slot in range(ring.slots)
        }
        self._slot_of = {buffer: slot for slot, buffer in self._buffers.items()}
        self.lent: set[int] = set()
        """Slots that the driver fills or may fill."""

    @property
    def resent_packets(self) -> int:
        """Packets that came on request, lost at first."""
        return self._count("n_resent_packets")

    @property
    def underruns(self) -> int:
        """Packets that met no free slot."""
        return self._count("n_underruns")

    @property
    def in_flight(self) -> bool:
        """Whether a frame is being received or waits to be taken."""
        empty, _ = self._stream.get_n_buffers()
        return bool(empty < len(self.lent))

    def lend(self, slot: int) -> None:
        """Let a slot be filled."""
        self._buffers[slot].set_frame_id(_NO_ID)
        self._stream.push_buffer(self._buffers[slot])
        self.lent.add(slot)

    def take(self, timeout_us: int) -> Iterator[ReceivedFrame]:
        """Yield the frames that have come; wait for the first so long at most."""
        buffer = self._stream.timeout_pop_buffer(timeout_us)
        while buffer is not None:
            yield self._taken(buffer)
            buffer = self._stream.try_pop_buffer()

    def close(self, *, lost: bool) -> list[ReceivedFrame]:
        """Return what had come, and stop receiving from a camera that is there or `lost`."""
        last = list(self.take(0))
        # The stream's end stops its thread; stopping that before makes Aravis complain.  A camera
        # can be opened again only when nothing of its stream is left.
        remains = [self._stream, self._slot_of, self._buffers]
        del self._stream, self._slot_of, self._buffers
        if lost:
            bury(remains)
        return last

    def _count(self, name: str) -> int:
        return int(self._stream.get_info_uint64_by_name(name)) if self._counts else 0

    def _taken(self, buffer: Any) -> ReceivedFrame:
        slot = self._slot_of[buffer]
        self.lent.discard(slot)
        flaw = _flaw(buffer.get_status())
        given = buffer.get_frame_id()
        return ReceivedFrame(
            slot=slot,
            frame_id=(given or None) if self._ids is None else self._ids.of(given),
            camera_ns=buffer.get_timestamp(),
            received_ns=buffer.get_system_timestamp(),
            width=0 if flaw else buffer.get_image_width(),
            height=0 if flaw else buffer.get_image_height(),
            flaw=flaw,
        )


class _FakeIds:
    """Block ids for Aravis' own camera, which counts from 65400 on and after 65535 from 0."""

    def __init__(self) -> None:
        self._last: int | None = None
        self._taken = 0

    def of(self, given: int) -> int:
        """Return the id that a GigE Vision camera would have given."""
        if self._last is not None:
            self._taken += (given - self._last) % 65536
        self._last = given
        return self._taken % 65535 + 1


def _flaw(status: Any) -> str | None:
    if status == Aravis.BufferStatus.SUCCESS:
        return None
    return str(status.value_nick).replace("-", " ")
