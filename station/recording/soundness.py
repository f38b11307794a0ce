"""Proving what stands around the pictures, without reading them.

Chunks carry checksums, and so does the summary; metadata and the records' headers do not.  The one
checksum over the whole data section covers them.  With the chunks' own checksums joined in, it is
computed from a few hundred bytes a frame.
"""

from mcap.opcode import Opcode

from station.recording.layout import PREFIX
from station.recording.opening import Recording
from station.recording.scan import scan

_END_LENGTH = PREFIX.size + 4


def ensure_sound_around_chunks(recording: Recording) -> None:
    """Let a recording pass whose data section has its checksum, its chunks being what they say.

    A chunk's checksum is believed here and compared when the chunk is read.  That of a compressed
    chunk is of its content, so its stored bytes are read.

    Raises
    ------
    RecordingUnreadable
        If the checksum does not match, or the records cannot be walked to their end.
    """
    found = scan(recording.descriptor)
    end = recording.read(found.end, _END_LENGTH)
    if not found.finished or len(end) < _END_LENGTH or found.end + len(end) != recording.data_end:
        raise recording.damaged(f"at byte {found.end}", ValueError("no record where one should be"))
    opcode, length = PREFIX.unpack_from(end)
    expected = int.from_bytes(end[PREFIX.size :], "little")
    if (opcode, length) != (Opcode.DATA_END, 4):
        raise recording.damaged(f"at byte {found.end}", ValueError("no end of the data"))
    # Other writers may leave it out, which reads as 0.
    if expected and expected != found.index.data_crc:
        error = ValueError("the checksum of the data section does not match")
        raise recording.damaged("around its pictures", error)
