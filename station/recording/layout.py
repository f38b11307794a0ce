"""The few byte layouts of MCAP that are read and written without the library."""

import struct

from mcap.data_stream import RecordBuilder
from mcap.exceptions import McapError
from mcap.records import McapRecord
from mcap.writer import MCAP0_MAGIC
from zstandard import ZstdError

MAGIC = MCAP0_MAGIC
"""The first and the last eight bytes of a file."""
PREFIX = struct.Struct("<BQ")
"""Before every record: opcode, length of what follows."""
CHUNK_START = struct.Struct("<QQQII")
"""First and last log time, uncompressed size, its CRC-32, length of the compression's name."""
MESSAGE_START = struct.Struct("<HIQQ")
"""Channel, sequence, log time, publish time."""
FOOTER_BODY = struct.Struct("<QQI")
"""Offset of the summary, of the summary offsets; CRC-32 of both with the footer's start."""
FOOTER_LENGTH = PREFIX.size + FOOTER_BODY.size

DAMAGED = (
    struct.error,
    ValueError,
    KeyError,
    McapError,
    ZstdError,
    RuntimeError,
    MemoryError,
    OverflowError,
)
"""What decoding damaged bytes can raise.

RuntimeError is lz4's; the last two come where a length is absurd.
"""


def encoded(record: McapRecord) -> bytes:
    """Return a record as it stands in a file."""
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
