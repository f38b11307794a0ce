"""foxglove.RawImage on the wire, without copying the picture.

The protobuf library copies a picture twice and holds the interpreter's lock meanwhile; at 120 MB/s
that starves the receiver.  Here the few bytes before and after the picture are made, and the
picture is written between them.  The order is that of the library, so the bytes are equal to its.
"""

from collections.abc import Iterator
from dataclasses import dataclass

# Field numbers of foxglove.RawImage and google.protobuf.Timestamp.
_TIMESTAMP, _WIDTH, _HEIGHT, _ENCODING, _STEP, _DATA, _FRAME_ID = range(1, 8)
_SECONDS, _NANOS = 1, 2
_VARINT, _FIXED64, _BYTES, _FIXED32 = 0, 1, 2, 5  # wire types
_NS = 1_000_000_000

MONO8 = "mono8"


@dataclass(frozen=True, slots=True)
class RawImage:
    """A decoded message; `data` is a view of the message it came from."""

    time_ns: int
    frame: str
    width: int
    height: int
    encoding: str
    step: int
    data: memoryview


def raw_image_around(
    time_ns: int, frame: str, width: int, height: int, size: int
) -> tuple[bytes, bytes]:
    """Return what stands before and after `size` bytes of a mono8 picture in its message."""
    seconds, nanos = divmod(time_ns, _NS)
    stamp = _number(_SECONDS, seconds) + _number(_NANOS, nanos)
    head = (
        _tag(_TIMESTAMP, _BYTES)
        + _varint(len(stamp))
        + stamp
        + _fixed32(_WIDTH, width)
        + _fixed32(_HEIGHT, height)
        + _text(_ENCODING, MONO8)
        + _fixed32(_STEP, width)
        + _tag(_DATA, _BYTES)
        + _varint(size)
    )
    return head, _text(_FRAME_ID, frame)


def read_raw_image(message: memoryview) -> RawImage:
    """Decode a message, fields in any order; ValueError where it is none."""
    numbers = {_WIDTH: 0, _HEIGHT: 0, _STEP: 0}
    parts = {field: memoryview(b"") for field in (_TIMESTAMP, _ENCODING, _DATA, _FRAME_ID)}
    for field, value in _fields(message):
        if field in numbers and isinstance(value, int):
            numbers[field] = value
        elif field in parts and isinstance(value, memoryview):
            parts[field] = value
    return RawImage(
        time_ns=_time_ns(parts[_TIMESTAMP]),
        frame=bytes(parts[_FRAME_ID]).decode(),
        width=numbers[_WIDTH],
        height=numbers[_HEIGHT],
        encoding=bytes(parts[_ENCODING]).decode(),
        step=numbers[_STEP],
        data=parts[_DATA],
    )


def _time_ns(stamp: memoryview) -> int:
    fields = {field: value for field, value in _fields(stamp) if isinstance(value, int)}
    return fields.get(_SECONDS, 0) * _NS + fields.get(_NANOS, 0)


def _fields(message: memoryview) -> Iterator[tuple[int, int | memoryview]]:
    """Yield (field number, value) of a protobuf message."""
    at = 0
    while at < len(message):
        tag, at = _read_varint(message, at)
        field, wire = tag >> 3, tag & 7
        if wire == _VARINT:
            value, at = _read_varint(message, at)
            yield field, value
            continue
        if wire == _BYTES:
            size, at = _read_varint(message, at)
        elif wire in {_FIXED32, _FIXED64}:
            size = 4 if wire == _FIXED32 else 8
        else:
            raise ValueError(f"field {field} has the unknown wire type {wire}")
        if at + size > len(message):
            raise ValueError(f"field {field} runs past the end of its message")
        body = message[at : at + size]
        yield field, body if wire == _BYTES else int.from_bytes(body, "little")
        at += size


def _read_varint(message: memoryview, at: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        if at >= len(message):
            raise ValueError("a number runs past the end of its message")
        byte = message[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
    raise ValueError("a number is longer than ten bytes")


def _varint(value: int) -> bytes:
    out = bytearray()
    while value >= 0x80:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    out.append(value)
    return bytes(out)


def _tag(field: int, wire: int) -> bytes:
    return _varint(field << 3 | wire)


def _number(field: int, value: int) -> bytes:
    return _tag(field, _VARINT) + _varint(value) if value else b""


def _fixed32(field: int, value: int) -> bytes:
    return _tag(field, _FIXED32) + value.to_bytes(4, "little") if value else b""


def _text(field: int, value: str) -> bytes:
    body = value.encode()
    return _tag(field, _BYTES) + _varint(len(body)) + body if body else b""
