"""What a recording's summary says, kept while it is written or scanned."""

import struct
from collections.abc import Iterable
from dataclasses import dataclass

from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from zlib_ng.zlib_ng import crc32

from station.recording.layout import FOOTER_BODY, MAGIC, PREFIX, encoded


@dataclass(frozen=True, slots=True)
class IndexedChunk:
    """A chunk with what is needed to take it back."""

    index: ChunkIndex
    counts: dict[int, int]
    """Messages per channel."""
    crc_before: int
    """Checksum of the data section up to the chunk."""


class FileIndex:
    """Schemas, channels, chunks, attachments and metadata of one file, in file order."""

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.chunks: list[IndexedChunk] = []
        self.data_crc = 0
        """Checksum of the data section so far."""
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []

    def add(self, record: McapRecord, offset: int, length: int) -> None:
        """Take note of a record at the top level of the file."""
        match record:
            case Schema():
                self.schemas[record.id] = record
            case Channel():
                self.channels[record.id] = record
            case Attachment():
                self._attachments.append(_index_of_attachment(record, offset, length))
            case Metadata():
                self._metadata.append(MetadataIndex(offset, length, record.name))

    @property
    def attachment_names(self) -> set[str]:
        """Names of the files put in."""
        return {attachment.name for attachment in self._attachments}

    @property
    def metadata_names(self) -> set[str]:
        """Names of the metadata records."""
        return {metadata.name for metadata in self._metadata}

    @property
    def end_of_last_chunk(self) -> int:
        """Offset behind the last chunk and its message indexes; 0 where there is none."""
        if not self.chunks:
            return 0
        last = self.chunks[-1].index
        return last.chunk_start_offset + last.chunk_length + last.message_index_length

    def schema_of(self, name: str) -> int | None:
        """Return the id of a schema by its name, where there is one."""
        return next((s.id for s in self.schemas.values() if s.name == name), None)

    def channel_of(self, topic: str) -> int | None:
        """Return the id of the channel of a topic, where there is one."""
        return next((c.id for c in self.channels.values() if c.topic == topic), None)

    def messages_on(self, topic: str) -> int:
        """Return how many messages a topic has."""
        channel = self.channel_of(topic)
        if channel is None:
            return 0
        return sum(chunk.counts.get(channel, 0) for chunk in self.chunks)

    def ending(self, data_end: int) -> bytes:
        """Return all that follows a data section that ends at offset `data_end`."""
        closing = encoded(DataEnd(self.data_crc))
        summary_start = data_end + len(closing)
        summary, offsets = b"", b""
        for opcode, records in self._groups():
            group = b"".join(encoded(record) for record in records)
            if group:
                start = summary_start + len(summary)
                offsets += encoded(SummaryOffset(opcode, start, len(group)))
                summary += group
        offsets_start = summary_start + len(summary)
        summary += offsets
        return closing + summary + _footer(summary, summary_start, offsets_start)

    def _groups(self) -> list[tuple[Opcode, Iterable[McapRecord]]]:
        return [
            (Opcode.SCHEMA, self.schemas.values()),
            (Opcode.CHANNEL, self.channels.values()),
            (Opcode.STATISTICS, [self.statistics()]),
            (Opcode.CHUNK_INDEX, [chunk.index for chunk in self.chunks]),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        ]

    def statistics(self) -> Statistics:
        """Return the counts of what is in the file."""
        counts: dict[int, int] = {}
        for chunk in self.chunks:
            for channel, count in chunk.counts.items():
                counts[channel] = counts.get(channel, 0) + count
        return Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self.channels),
            channel_message_counts=counts,
            chunk_count=len(self.chunks),
            message_count=sum(counts.values()),
            message_start_time=min((c.index.message_start_time for c in self.chunks), default=0),
            message_end_time=max((c.index.message_end_time for c in self.chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self.schemas),
        )


def _index_of_attachment(record: Attachment, offset: int, length: int) -> AttachmentIndex:
    return AttachmentIndex(
        offset=offset,
        length=length,
        log_time=record.log_time,
        create_time=record.create_time,
        data_size=len(record.data),
        name=record.name,
        media_type=record.media_type,
    )


def _footer(summary: bytes, summary_start: int, offsets_start: int) -> bytes:
    start = PREFIX.pack(Opcode.FOOTER, FOOTER_BODY.size)
    start += struct.pack("<QQ", summary_start, offsets_start)
    crc = crc32(start, crc32(summary))
    return encoded(Footer(summary_start, offsets_start, crc)) + MAGIC
