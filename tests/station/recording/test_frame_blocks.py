"""A recording in blocks: together they are the recording, each can be read elsewhere."""

import pickle

import numpy as np
import pytest
from recording_samples import make_recording

from station.errors import RecordingUnreadable
from station.recording import frame_blocks, frames


@pytest.fixture
def recording(tmp_path, rng):
    path = tmp_path / "r.mcap"
    make_recording(path, rng, count=7)
    return path


def read_all(blocks):
    return [frame for block in blocks for frame in block.frames()]


@pytest.mark.parametrize("chunks_each", [1, 2, 3, 100])
def test_blocks_in_order_hold_every_frame_once(recording, chunks_each):
    blocks = frame_blocks(recording, chunks_each=chunks_each)
    found = read_all(blocks)
    expected = list(frames(recording))
    assert [(f.sensor, f.frame_id, f.camera_time_ns, f.exposure_us) for f in found] == [
        (f.sensor, f.frame_id, f.camera_time_ns, f.exposure_us) for f in expected
    ]
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one.picture, other.picture)


def test_a_block_handed_to_another_process_reads_the_same_frames(recording):
    for block in frame_blocks(recording, chunks_each=3):
        again = pickle.loads(pickle.dumps(block))
        ids = [frame.frame_id for frame in block.frames()]
        assert [frame.frame_id for frame in again.frames()] == ids


def test_damage_within_a_chunk_is_found_when_its_block_is_read(recording):
    content = bytearray(recording.read_bytes())
    content[len(content) // 2] ^= 1
    recording.write_bytes(content)
    blocks = frame_blocks(recording, chunks_each=1)
    with pytest.raises(RecordingUnreadable, match="damaged"):
        read_all(blocks)


def test_a_file_that_is_cut_has_no_blocks(recording):
    recording.write_bytes(recording.read_bytes()[:-100])
    with pytest.raises(RecordingUnreadable, match="cut short"):
        frame_blocks(recording, chunks_each=1)
