"""Packets put together again are the picture; the decoder here is written from the specification
and shares nothing with the encoder."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.simulated.gvsp import (
    BlockHeader,
    FramePackets,
    Region,
    as_resent,
    encode_unavailable,
    next_block_id,
)


def put_together(packets):
    """Return (block id, timestamp, width, height, pixels) of one picture's packets."""
    leader, *payload, trailer = (bytes(packet) for packet in packets)
    block = struct.unpack(">H", leader[2:4])[0]
    assert leader[4] == 1
    assert leader[10:12] == b"\0\1"
    (timestamp,) = struct.unpack(">Q", leader[12:20])
    width, height = struct.unpack(">II", leader[24:32])
    pixels = b""
    for number, packet in enumerate(payload, start=1):
        status, block_id, word = struct.unpack(">HHI", packet[:8])
        assert (status, block_id, word >> 24, word & 0xFFFFFF) == (0, block, 3, number)
        pixels += packet[8:]
    assert trailer[4] == 2
    assert struct.unpack(">I", trailer[4:8])[0] & 0xFFFFFF == len(payload) + 1
    return block, timestamp, width, height, pixels


@given(
    width=st.integers(1, 90),
    height=st.integers(1, 40),
    packet_bytes=st.integers(37, 1500),
    block_id=st.integers(1, 65535),
    timestamp_ns=st.integers(0, 2**64 - 1),
    seed=st.integers(0, 9),
)
def test_packets_put_together_are_the_picture(
    width, height, packet_bytes, block_id, timestamp_ns, seed
):
    picture = np.random.default_rng(seed).integers(0, 256, (height, width), dtype=np.uint8)
    frame = FramePackets(picture.size, packet_bytes)
    frame.fill(BlockHeader(block_id, timestamp_ns, Region(width, height)), picture)
    assert put_together(frame.packets) == (
        block_id,
        timestamp_ns,
        width,
        height,
        picture.tobytes(),
    )
    assert all(len(packet) <= packet_bytes - 28 for packet in frame.packets[1:-1])


def test_memory_used_again_holds_nothing_of_the_picture_before(rng):
    first, second = rng.integers(0, 256, (2, 33, 57), dtype=np.uint8)
    frame = FramePackets(first.size, 576)
    for block_id, picture in ((1, first), (2, second)):
        frame.fill(BlockHeader(block_id, 5, Region(57, 33)), picture)
    assert put_together(frame.packets) == (2, 5, 57, 33, second.tobytes())


def test_a_packet_sent_again_differs_in_its_status_alone():
    frame = FramePackets(1000, 576)
    frame.fill(BlockHeader(3, 0, Region(50, 20)), np.ones((20, 50), np.uint8))
    packet = bytes(frame.packets[1])
    again = b"".join(as_resent(frame.packets[1]))
    assert again[:2] == b"\x01\x00"
    assert again[2:] == packet[2:]


def test_an_unavailable_packet_says_which_one_is_gone():
    status, block_id, word = struct.unpack(">HHI", encode_unavailable(17, 5))
    assert (status, block_id, word & 0xFFFFFF) == (0x800C, 17, 5)


def test_block_ids_wrap_from_65535_to_1():
    assert [next_block_id(i) for i in (1, 65534, 65535)] == [2, 65535, 1]


def test_a_region_cuts_its_own_pixels(rng):
    picture = rng.integers(0, 256, (40, 60), dtype=np.uint8)
    cut = Region(width=20, height=10, offset_x=7, offset_y=3).cut(picture)
    np.testing.assert_array_equal(cut, picture[3:13, 7:27])


@pytest.mark.parametrize("region", [Region(61, 40), Region(60, 40, 1, 0), Region(0, 5)])
def test_a_region_beyond_the_sensor_does_not_fit(region):
    assert not region.fits(60, 40)
