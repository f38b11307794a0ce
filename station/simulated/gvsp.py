"""GVSP, the stream protocol of GigE Vision: one picture as leader, payload packets and trailer.

Pure: nothing here knows a socket. Block ids are the 16-bit ones of GigE Vision 1.x: 1 to 65535,
then 1 again; 0 is reserved.
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib import Picture
from station.simulated.gvcp import Status

MONO8 = 0x01080001
LAST_BLOCK_ID = 65535
IP_UDP_BYTES = 28  # GevSCPSPacketSize counts the IP and UDP headers

_HEADER_BYTES = 8
_HEADER = struct.Struct(">HHI")
_LEADER = struct.Struct(">HHQIIIIIHH")
_TRAILER = struct.Struct(">HHI")
_FORMAT_LEADER, _FORMAT_TRAILER, _FORMAT_PAYLOAD = 1 << 24, 2 << 24, 3 << 24
_PAYLOAD_TYPE_IMAGE = 1


def next_block_id(block_id: int) -> int:
    """Return the id of the block after `block_id`.

    >>> next_block_id(1), next_block_id(65535)
    (2, 1)
    """
    return block_id % LAST_BLOCK_ID + 1


@dataclass(frozen=True, slots=True)
class Region:
    """The part of the sensor that is read out, px."""

    width: int
    height: int
    offset_x: int = 0
    offset_y: int = 0

    @property
    def payload_bytes(self) -> int:
        return self.width * self.height

    def fits(self, width_max: int, height_max: int) -> bool:
        """Return whether the region lies on a sensor of that size."""
        return (
            0 < self.width <= width_max - self.offset_x
            and 0 < self.height <= height_max - self.offset_y
        )

    def cut(self, picture: Picture) -> Picture:
        """Return the region's pixels, row after row without gaps."""
        rows = slice(self.offset_y, self.offset_y + self.height)
        columns = slice(self.offset_x, self.offset_x + self.width)
        return np.ascontiguousarray(picture[rows, columns])


@dataclass(frozen=True, slots=True)
class BlockHeader:
    """What a picture's leader says of it."""

    block_id: int
    timestamp_ns: int
    region: Region


class FramePackets:
    """All packets of one picture, in memory that is used again for the next one.

    A packet is a view of one row of a single array, so that filling a frame is two array
    assignments and sending it copies nothing.
    """

    def __init__(self, payload_bytes: int, packet_bytes: int) -> None:
        """Lay out the packets of a payload for a GevSCPSPacketSize of `packet_bytes`."""
        self.payload_bytes = payload_bytes
        self.packet_bytes = packet_bytes
        self.block_id: int | None = None
        self._data_bytes = packet_bytes - IP_UDP_BYTES - _HEADER_BYTES
        count = -(-payload_bytes // self._data_bytes)
        self._rows = np.zeros((count, _HEADER_BYTES + self._data_bytes), dtype=np.uint8)
        self._last_bytes = payload_bytes - (count - 1) * self._data_bytes
        self._payload = [row.data for row in self._rows]
        self._payload[-1] = self._payload[-1][: _HEADER_BYTES + self._last_bytes]
        self.packets: list[memoryview] = []

    def fill(self, header: BlockHeader, pixels: Picture) -> None:
        """Put a picture of `payload_bytes` pixels into the packets."""
        self.block_id = header.block_id
        self._write_headers(header.block_id)
        flat = pixels.reshape(-1)
        full = len(flat) - self._last_bytes
        self._rows[:-1, _HEADER_BYTES:] = flat[:full].reshape(-1, self._data_bytes)
        self._rows[-1, _HEADER_BYTES : _HEADER_BYTES + self._last_bytes] = flat[full:]
        leader = memoryview(encode_leader(header))
        trailer = memoryview(encode_trailer(header, packet_id=len(self._payload) + 1))
        self.packets = [leader, *self._payload, trailer]

    def _write_headers(self, block_id: int) -> None:
        words: NDArray[np.uint32] = np.empty((len(self._rows), 2), dtype=">u4")
        words[:, 0] = block_id  # the status in the upper half is 0, SUCCESS
        words[:, 1] = _FORMAT_PAYLOAD + np.arange(1, len(self._rows) + 1)
        self._rows[:, :_HEADER_BYTES] = words.view(np.uint8)


def encode_leader(header: BlockHeader) -> bytes:
    """Return the packet that announces a picture."""
    region = header.region
    return _HEADER.pack(Status.SUCCESS, header.block_id, _FORMAT_LEADER) + _LEADER.pack(
        0,
        _PAYLOAD_TYPE_IMAGE,
        header.timestamp_ns,
        MONO8,
        region.width,
        region.height,
        region.offset_x,
        region.offset_y,
        0,
        0,
    )


def encode_trailer(header: BlockHeader, packet_id: int) -> bytes:
    """Return the packet that ends a picture."""
    return _HEADER.pack(
        Status.SUCCESS, header.block_id, _FORMAT_TRAILER | packet_id
    ) + _TRAILER.pack(0, _PAYLOAD_TYPE_IMAGE, header.region.height)


def encode_unavailable(block_id: int, packet_id: int) -> bytes:
    """Return the packet that says: this one cannot be sent again."""
    return _HEADER.pack(Status.PACKET_UNAVAILABLE, block_id, _FORMAT_PAYLOAD | packet_id)


def as_resent(packet: memoryview) -> tuple[bytes, memoryview]:
    """Return the two parts of a packet marked as sent again; joined they are the datagram."""
    return Status.PACKET_RESEND.to_bytes(2, "big"), packet[2:]
