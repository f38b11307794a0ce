"""GVCP, the control protocol of GigE Vision: commands and acknowledges as bytes.

Pure: nothing here knows a socket or a register. Names and numbers are those of the GigE Vision
specification 1.2; all fields are big-endian.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from typing import Self

PORT = 3956
MAX_MEMORY_BYTES = 536  # the most one READMEM or WRITEMEM carries

_KEY = 0x42
_FLAG_ACKNOWLEDGE = 0x01
_HEADER = struct.Struct(">BBHHH")
_ACK_HEADER = struct.Struct(">HHHH")
_RESEND = struct.Struct(">HHII")
_PACKET_ID_MASK = 0xFFFFFF


class Command(IntEnum):
    """The commands this device speaks; an acknowledge carries the number plus one."""

    DISCOVERY = 0x0002
    PACKET_RESEND = 0x0040
    READ_REGISTER = 0x0080
    WRITE_REGISTER = 0x0082
    READ_MEMORY = 0x0084
    WRITE_MEMORY = 0x0086


class Status(IntEnum):
    """How a command ended, or what a stream packet is."""

    SUCCESS = 0x0000
    PACKET_RESEND = 0x0100
    NOT_IMPLEMENTED = 0x8001
    INVALID_PARAMETER = 0x8002
    INVALID_ADDRESS = 0x8003
    WRITE_PROTECT = 0x8004
    BAD_ALIGNMENT = 0x8005
    ACCESS_DENIED = 0x8006
    BUSY = 0x8007
    PACKET_UNAVAILABLE = 0x800C


class MalformedPacket(ValueError):
    """The bytes are not the packet they should be."""


@dataclass(frozen=True, slots=True)
class Request:
    """One command; `command` is a plain number because a device must answer unknown ones too."""

    command: int
    request_id: int
    payload: bytes = b""
    wants_acknowledge: bool = True

    def encode(self) -> bytes:
        flags = _FLAG_ACKNOWLEDGE if self.wants_acknowledge else 0
        header = _HEADER.pack(_KEY, flags, self.command, len(self.payload), self.request_id)
        return header + self.payload

    @classmethod
    def decode(cls, datagram: bytes) -> Self:
        """Read a command from a datagram.

        Raises
        ------
        MalformedPacket
            If it is not GVCP, says a length it does not have, or carries request id 0.
        """
        if len(datagram) < _HEADER.size:
            raise MalformedPacket(f"{len(datagram)} bytes are less than a GVCP header")
        key, flags, command, length, request_id = _HEADER.unpack_from(datagram)
        payload = datagram[_HEADER.size :]
        if not (key == _KEY and length == len(payload) and request_id != 0):
            raise MalformedPacket(
                f"key {key:#x}, length {length} of {len(payload)}, request id {request_id}"
            )
        return cls(command, request_id, payload, bool(flags & _FLAG_ACKNOWLEDGE))


@dataclass(frozen=True, slots=True)
class Acknowledge:
    """The answer to one command; `command` is the number of the command it answers."""

    status: int
    command: int
    request_id: int
    payload: bytes = b""

    def encode(self) -> bytes:
        code = (self.command + 1) & 0xFFFF
        header = _ACK_HEADER.pack(self.status, code, len(self.payload), self.request_id)
        return header + self.payload

    @classmethod
    def decode(cls, datagram: bytes) -> Self:
        """Read an acknowledge from a datagram.

        Raises
        ------
        MalformedPacket
            If it is shorter than a header or says a length it does not have.
        """
        if len(datagram) < _ACK_HEADER.size:
            raise MalformedPacket(f"{len(datagram)} bytes are less than a GVCP header")
        status, code, length, request_id = _ACK_HEADER.unpack_from(datagram)
        payload = datagram[_ACK_HEADER.size :]
        if length != len(payload):
            raise MalformedPacket(f"length {length} of {len(payload)}")
        return cls(status, (code - 1) & 0xFFFF, request_id, payload)


@dataclass(frozen=True, slots=True)
class ResendRequest:
    """Which packets of a block a receiver wants again, both ends included."""

    block_id: int
    first_packet: int
    last_packet: int

    def encode(self) -> bytes:
        return _RESEND.pack(0, self.block_id, self.first_packet, self.last_packet)

    @classmethod
    def decode(cls, payload: bytes) -> Self:
        if len(payload) < _RESEND.size:
            raise MalformedPacket(f"{len(payload)} bytes are less than a resend request")
        _channel, block_id, first, last = _RESEND.unpack_from(payload)
        return cls(block_id, first & _PACKET_ID_MASK, last & _PACKET_ID_MASK)


def encode_addresses(addresses: list[int]) -> bytes:
    """Return the payload of READREG."""
    return struct.pack(f">{len(addresses)}I", *addresses)


def decode_addresses(payload: bytes) -> list[int]:
    """Return the register addresses of a READREG payload."""
    if not payload or len(payload) % 4:
        raise MalformedPacket(f"{len(payload)} bytes are no list of addresses")
    return list(struct.unpack(f">{len(payload) // 4}I", payload))


def encode_writes(writes: list[tuple[int, int]]) -> bytes:
    """Return the payload of WRITEREG."""
    return b"".join(struct.pack(">II", address, value) for address, value in writes)


def decode_writes(payload: bytes) -> list[tuple[int, int]]:
    """Return the (address, value) pairs of a WRITEREG payload."""
    if not payload or len(payload) % 8:
        raise MalformedPacket(f"{len(payload)} bytes are no list of register writes")
    return [(address, value) for address, value in struct.iter_unpack(">II", payload)]


def encode_memory_read(address: int, count: int) -> bytes:
    """Return the payload of READMEM."""
    return struct.pack(">IHH", address, 0, count)


def decode_memory_read(payload: bytes) -> tuple[int, int]:
    """Return the address and the byte count of a READMEM payload."""
    if len(payload) != 8:
        raise MalformedPacket(f"{len(payload)} bytes are no memory read")
    address, _reserved, count = struct.unpack(">IHH", payload)
    return address, count


def encode_memory_write(address: int, data: bytes) -> bytes:
    """Return the payload of WRITEMEM."""
    return struct.pack(">I", address) + data


def decode_memory_write(payload: bytes) -> tuple[int, bytes]:
    """Return the address and the data of a WRITEMEM payload."""
    if len(payload) < 8:
        raise MalformedPacket(f"{len(payload)} bytes are no memory write")
    (address,) = struct.unpack_from(">I", payload)
    return address, payload[4:]


def encode_index(count: int) -> bytes:
    """Return the payload of a WRITEREG or WRITEMEM acknowledge: how much was written."""
    return struct.pack(">HH", 0, count)
