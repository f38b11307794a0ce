"""Shows that frames are found by their place where another program wrote the recording, with an
index of its messages or without; the recorder's own are shown with the API."""

import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.writer import IndexType, Writer

from station.errors import NotFound
from station.recording import FrameTable, list_frames

SHAPE = (20, 30)
FRAMES = 7


@pytest.fixture(params=[IndexType.CHUNK, IndexType.ALL], ids=["chunks alone", "messages too"])
def foreign(request, tmp_path):
    path = tmp_path / "foreign.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=1500, index_types=request.param)
        writer.start()
        schema = writer.register_schema("foxglove.RawImage", "protobuf", b"")
        channel = writer.register_channel("/left/image", "protobuf", schema)
        other = writer.register_channel("/rosout", "json", 0)
        for number in range(1, FRAMES + 1):
            writer.add_message(other, number, b"{}", number, 0)
            image = RawImage(
                width=SHAPE[1],
                height=SHAPE[0],
                step=SHAPE[1],
                encoding="mono8",
                data=bytes([number]) * (SHAPE[0] * SHAPE[1]),
            )
            body = image.SerializeToString()
            writer.add_message(channel, 10 * number + 5, body, 10 * number, 40 + number)
        writer.finish()
    return path


def test_frames_of_another_program_are_listed_from_any_place(foreign):
    for after in range(FRAMES + 1):
        found = list_frames([foreign], after=after, most=3)
        assert [each.number for each in found] == list(range(after + 1, FRAMES + 1))[:3]
        assert [each.frame_id for each in found] == [40 + each.number for each in found]
        assert [(each.camera_time_ns, each.host_time_ns) for each in found] == [
            (10 * each.number, 10 * each.number + 5) for each in found
        ]


def test_a_frame_of_another_program_is_seen(foreign):
    table = FrameTable.of([foreign])
    for number in range(1, FRAMES + 1):
        listed, picture = table.frame(number)
        assert [listed] == list_frames([foreign], after=number - 1, most=1)
        np.testing.assert_array_equal(picture, np.full(SHAPE, number, np.uint8))
    with pytest.raises(NotFound, match="has 7 frames; there is no frame 8"):
        table.frame(FRAMES + 1)
