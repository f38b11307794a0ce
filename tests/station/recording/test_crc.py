"""The checksum of a whole from those of its parts."""

import zlib

from hypothesis import given
from hypothesis import strategies as st

from station.recording.crc import joined_crc


@given(st.binary(max_size=300), st.binary(max_size=300))
def test_joined_checksum_is_that_of_the_whole(first, second):
    joined = joined_crc(zlib.crc32(first), zlib.crc32(second), len(second))
    assert joined == zlib.crc32(first + second)


def test_joined_checksum_is_right_for_a_picture(rng):
    first, second = rng.bytes(77), rng.bytes(2048 * 1088)
    joined = joined_crc(zlib.crc32(first), zlib.crc32(second), len(second))
    assert joined == zlib.crc32(second, zlib.crc32(first))
